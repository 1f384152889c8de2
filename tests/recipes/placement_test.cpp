#include <gtest/gtest.h>
#include <random>

#include "core/units.hpp"
#include "recipes/job.hpp"

namespace gantry::recipes {
namespace {

config::Machine dispenser() { return *config::load_machine("config/machines/dispenser.yaml"); }
Recipe demo() { return *load("recipes/demo-board.yaml"); }

/// Where a tool's tip stands by the machine's own rule: p + (X, Y, Z), lower by U when it rides on the lift.
Vec3 tip_of(const config::Machine& m, const config::Tool& tool, const AxisVec& q) {
  const double u = tool.lift_mm > 0 ? q[m.u->value] : 0;
  return {tool.tip.x + q[m.x.value], tool.tip.y + q[m.y.value], tool.tip.z + q[m.z.value] - u};
}

TEST(Placement, brings_each_tool_to_the_point) {
  const auto m = dispenser();
  const unsigned seed = 7;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-300, 300);
  for (const auto& tool : m.tools)
    for (int i = 0; i < 100; ++i) {
      const Vec3 want{any(random), any(random), any(random)};
      const AxisVec q = tool_at(m, tool, want, 0.25);
      EXPECT_LT(norm(tip_of(m, tool, q) - want), 1e-9) << tool.name << " seed " << seed;
      EXPECT_EQ(q[m.c->value], 0.25);
      EXPECT_EQ(q[m.u->value], tool.lift_mm);
    }
}

TEST(Placement, turns_about_the_boards_origin_and_then_shifts) {
  const auto m = dispenser();
  const Recipe r = demo();
  const Vec3 origin = config::find_frame(m, "pallet")->origin;
  // A quarter turn takes (10, 0) to (0, 10).
  const Vec3 p = to_machine(r, m, {{1, 2}, units::rad(90)}, {0.5, {0.01, 0}}, {10, 0}, 0.2);
  EXPECT_NEAR(p.x, origin.x + 1, 1e-9);
  EXPECT_NEAR(p.y, origin.y + 12, 1e-9);
  EXPECT_NEAR(p.z, origin.z + 12 + 0.5 + 0.1 + 0.2, 1e-9);
}

TEST(Placement, parts_move_with_the_board_and_fixtures_stay) {
  const auto m = dispenser();
  const Recipe r = demo();
  const auto nominal = bodies(r, m, {}, {});
  const auto moved = bodies(r, m, {{2, -1}, 0.01}, {0.3, {}});
  ASSERT_EQ(nominal.size(), r.parts.size() + 1);
  EXPECT_EQ(nominal[0].name, "board");
  const double top = config::find_frame(m, "pallet")->origin.z + r.board.thickness;
  EXPECT_NEAR(nominal[0].centre.z + nominal[0].shape.size.z / 2, top, 1e-9);
  for (std::size_t i = 0; i < r.parts.size(); ++i) {
    const auto &a = nominal[i + 1], &b = moved[i + 1];
    if (r.parts[i].fixture) {
      EXPECT_TRUE(a.centre == b.centre) << a.name;
      EXPECT_NEAR(a.centre.z - a.shape.size.z / 2, top - r.board.thickness, 1e-9) << "stands on the pallet";
    } else {
      EXPECT_NEAR(a.centre.z - a.shape.size.z / 2, top, 1e-9) << "stands on the board";
      EXPECT_NEAR(b.centre.z - a.centre.z, 0.3, 1e-9);
      EXPECT_NEAR(b.rotation_rad - a.rotation_rad, 0.01, 1e-12);
    }
  }
}

}  // namespace
}  // namespace gantry::recipes
