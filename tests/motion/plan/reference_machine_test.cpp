// The reference machine's own bodies: its tools reach a board and go from one to the other, and what cannot work is
// refused with its reason.
#include <gtest/gtest.h>

#include "motion/plan/find_path.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

class ReferenceMachine : public testing::Test {
 protected:
  ReferenceMachine() : machine(load()), scene(machine) {
    const Vec3 origin = config::find_frame(machine, "pallet")->origin;
    corner = {origin.x, origin.y, origin.z + 1.6};
    scene.add(test::box("board", {120, 80, 1.6}, corner + Vec3{60, 40, -0.8}));
    scene.add(test::box("part J1", {20, 10, 12}, corner + Vec3{60, 40, 6}));
  }
  static config::Machine load() {
    auto loaded = config::load_machine(GANTRY_SOURCE_DIR "/config/machines/dispenser.yaml");
    if (!loaded) ADD_FAILURE() << to_text(loaded.error().front());
    return loaded ? *std::move(loaded) : config::Machine{};
  }
  /// Axes that bring a tool's tip to a point of the board.
  [[nodiscard]] AxisVec tool_at(const char* name, Vec2 at, double height) const {
    const config::Tool& tool = *config::find_tool(machine, name);
    const Vec3 p = corner + Vec3{at.x, at.y, height} - tool.tip;
    AxisVec q{};
    q[machine.x.value] = p.x, q[machine.y.value] = p.y, q[machine.z.value] = p.z + tool.lift_mm;
    q[machine.u->value] = tool.lift_mm;
    return q;
  }
  config::Machine machine;
  Scene scene;
  Vec3 corner;
};

TEST_F(ReferenceMachine, camera_needle_and_probe_reach_the_whole_board) {
  const PathRules rules{.clearance_mm = machine.clearance_mm,
                        .approaches = {{"needle", "board", 0.18},
                                       {"needle", "pallet_plate", 0.18 + 1.6},  // which the thin board lies on
                                       {"probe_stylus", "board", -0.5}}};
  AxisVec from{};
  for (const auto& [axis, value] : machine.park) from[axis.value] = value;
  int straight = 0, over = 0;
  for (const char* tool : {"camera", "probe", "needle", "camera", "needle", "probe"})
    for (const Vec2 at : {Vec2{5, 5}, Vec2{115, 5}, Vec2{115, 75}, Vec2{5, 75}, Vec2{40, 40}, Vec2{80, 40}}) {
      const double height = tool[0] == 'n' ? 0.2 : tool[0] == 'p' ? 3 : 0;
      const AxisVec to = tool_at(tool, at, height);
      const auto path = find_path(scene, from, to, rules);
      ASSERT_TRUE(path) << tool << " at " << at.x << ", " << at.y << ": " << path.error().message;
      ++(path->kind == PathKind::Straight ? straight : over);
      from = to;
    }
  std::printf("%d straight, %d lifted over\n", straight, over);
  EXPECT_GT(straight, 5);
  EXPECT_GT(over, 5);
}

TEST_F(ReferenceMachine, the_needle_does_not_go_down_on_the_clamp_rail) {
  const auto path = find_path(scene, tool_at("needle", {60, 20}, 5), tool_at("needle", {60, -10}, 0.2),
                              {.clearance_mm = machine.clearance_mm,
                               .approaches = {{"needle", "board", 0.18}, {"needle", "pallet_plate", 0.18}}});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().fault, Fault::Collision);
  EXPECT_NE(path.error().message.find("needle comes within 2 mm of clamp_rail"), std::string::npos)
      << path.error().message;
}

}  // namespace
}  // namespace gantry::motion
