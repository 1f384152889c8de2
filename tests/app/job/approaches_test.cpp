// Which pair may come nearer than the clearance, and in which step of a job. The judge of distances is
// tests/motion/plan/prism_distance.hpp, which shares nothing with the code that is judged.
#include <gtest/gtest.h>

#include "app/job/block_plan.hpp"
#include "motion/geometry.hpp"
#include "tests/app/job/reference.hpp"
#include "tests/motion/plan/prism_distance.hpp"

namespace gantry::job {
namespace {

constexpr const char* kTouches =
    "touches:\n  t0: {at: [10 mm, 10 mm]}\n  t1: {at: [70 mm, 10 mm]}\n  t2: {at: [40 mm, 45 mm]}\n"
    "touch_rules: {window: 1.5 mm}\n";

enum class Fixed { ToBoard, ToPallet, ToMachine };

/// A machine and a recipe of dots and touches on it, which tests may alter.
struct Table {
  config::Machine machine = test::reference();
  recipes::Recipe recipe = test::dots(2, 3, kTouches);
  AxisVec park = test::parked(machine);

  /// A clip of 3 x 3 mm whose top is `above_mm` over the board's nominal surface.
  void add_clip(Fixed fixed, Vec2 at, double above_mm) {
    const double thick = recipe.board.thickness;
    if (fixed != Fixed::ToMachine) {
      const bool fixture = fixed == Fixed::ToPallet;
      recipe.parts.push_back({.name = "clip",
                              .at = at,
                              .size = {3, 3, above_mm + (fixture ? thick : 0)},
                              .fixture = fixture,
                              .location = {}});
      return;
    }
    const Vec3 p = recipes::to_machine(recipe, machine, {}, {}, at, above_mm / 2);
    machine.scene.push_back({"clip", {config::Shape::Kind::Box, {3, 3, above_mm}}, p, 0, false});
  }
};

std::string line(const recipes::Location& location) {
  return "dots.yaml:" + std::to_string(location.line) + ":" + std::to_string(location.column);
}

/// Whatever the clip is fixed to: the probe would read it, and the needle would go into the board.
TEST(Approaches, a_clip_under_a_touch_is_refused_with_both_bodies_and_the_line) {
  for (const Fixed fixed : {Fixed::ToBoard, Fixed::ToPallet, Fixed::ToMachine})
    for (const double above : {0.05, 0.5, 1.0, 1.4, 1.6, 3.0}) {
      Table t;
      t.add_clip(fixed, {70.5, 10.5}, above);
      const BlockPlanner planner(t.machine, t.recipe);
      const auto block = planner.touch(1, t.park, 1);
      ASSERT_FALSE(block) << above << " mm, fixed to " << static_cast<int>(fixed);
      EXPECT_EQ(block.error().fault, Fault::Collision);
      for (const char* word : {"probe_stylus", "clip", "touch 't1'"})
        EXPECT_NE(block.error().message.find(word), std::string::npos) << block.error().message;
      EXPECT_EQ(block.error().where, line(t.recipe.touches[1].location));
      EXPECT_TRUE(planner.touch(1, t.park, 0)) << "nothing lies there";
    }
}

/// A touch beside a clip: free from the clearance on, by the closed form.
TEST(Approaches, beside_a_clip_the_clearance_decides_and_nothing_else) {
  for (const Fixed fixed : {Fixed::ToBoard, Fixed::ToPallet, Fixed::ToMachine})
    for (const double off : {-1e-3, -1e-6, 1e-6, 1e-3}) {
      Table t;
      const double stylus_radius = 1.5, half_clip = 1.5;
      t.add_clip(fixed, {70 + stylus_radius + half_clip + t.machine.clearance_mm + off, 10}, 1.0);
      const BlockPlanner planner(t.machine, t.recipe);
      EXPECT_EQ(planner.touch(1, t.park, 1).has_value(), off > 0) << off << ", fixed to " << static_cast<int>(fixed);
    }
}

/// The needle's tip is 6 mm over the probe's: in a touch it comes down to 4.5 mm over the nominal surface, and what
/// rides on the board rides with the surface that ends the touch. The window must not be counted twice.
TEST(Approaches, the_window_grows_nothing_that_rides_on_the_board_while_a_touch_is_under_way) {
  for (const Fixed fixed : {Fixed::ToBoard, Fixed::ToPallet, Fixed::ToMachine})
    for (const double off : {-1e-3, -1e-6, 1e-6, 1e-3}) {
      Table t;
      // 40 mm to the right of the probe
      t.add_clip(fixed, {10 + 40, 10}, 6 - 1.5 - t.machine.clearance_mm - off);
      const BlockPlanner planner(t.machine, t.recipe);
      const auto block = planner.touch(1, t.park, 0);
      EXPECT_EQ(block.has_value(), off > 0) << off << ", fixed to " << static_cast<int>(fixed);
      if (!block) {
        EXPECT_NE(block.error().message.find("needle"), std::string::npos) << block.error().message;
      }
    }
}

/// What lies lower than the board's surface is no board either.
TEST(Approaches, nothing_is_inherited_by_what_stands_lower) {
  Table t;
  t.recipe.board.thickness = 12;
  const Vec3 corner = recipes::to_machine(t.recipe, t.machine, {}, {}, {-4, 10}, -1);
  t.machine.scene.push_back({"ledge", {config::Shape::Kind::Box, {7, 10, 2}}, corner, 0, false});  // top: the board's
  t.recipe.touches[0].at = {0.5, 10};
  const auto touch = BlockPlanner(t.machine, t.recipe).touch(1, t.park, 0);
  ASSERT_FALSE(touch);
  EXPECT_NE(touch.error().message.find("ledge"), std::string::npos) << touch.error().message;
  std::get<recipes::Dot>(t.recipe.features[0]).at = {0.5, 10};
  const auto dot = BlockPlanner(t.machine, t.recipe).dispense(1, t.park, {0});
  ASSERT_FALSE(dot);
  EXPECT_NE(dot.error().message.find("ledge"), std::string::npos) << dot.error().message;
}

/// A thin board lies on its plate within any clearance: the plate stands under the board, and the board between.
TEST(Approaches, what_carries_a_thin_board_may_be_as_near_as_the_board_is_thin) {
  Table t;
  t.recipe.board.thickness = 0.8;
  std::get<recipes::Dot>(t.recipe.features[0]).at = {20, 20};
  const BlockPlanner planner(t.machine, t.recipe);
  EXPECT_TRUE(planner.touch(1, t.park, 0));
  EXPECT_TRUE(planner.dispense(1, t.park, {0}));
  // A shelf that the board does not lie on is none of it.
  t.machine.scene.push_back({"shelf",
                             {config::Shape::Kind::Box, {6, 6, 1}},
                             recipes::to_machine(t.recipe, t.machine, {}, {}, {20, 20}, 1.0),
                             0,
                             false});
  EXPECT_FALSE(BlockPlanner(t.machine, t.recipe).dispense(1, t.park, {0}));
}

/// The probe near the board is no design while dots are dispensed, nor the needle near it in a touch.
TEST(Approaches, a_named_pair_is_named_in_its_own_phase_only) {
  Table t;
  ASSERT_TRUE(BlockPlanner(t.machine, t.recipe).dispense(1, t.park, {2}));
  const double longer = 30 - 6 + 0.5 - 1;  // the probe ends 1 mm over the board while the needle dispenses
  for (config::Body& body : t.machine.head)
    if (body.name == "probe_stylus") body.centre.z -= longer;
  for (config::Tool& tool : t.machine.tools)
    if (tool.name == "probe") tool.tip.z -= longer;
  const auto dot = BlockPlanner(t.machine, t.recipe).dispense(1, t.park, {2});
  ASSERT_FALSE(dot);
  EXPECT_NE(dot.error().message.find("probe_stylus"), std::string::npos) << dot.error().message;
  t.machine = test::reference();
  const double lower = 6 - 1.5 - 1;  // the needle is 1 mm over the surface when the probe is at the window's lower end
  for (config::Body& body : t.machine.head)
    if (body.name == "needle") body.centre.z -= lower;
  for (config::Tool& tool : t.machine.tools)
    if (tool.name == "needle") tool.tip.z -= lower;
  const auto touch = BlockPlanner(t.machine, t.recipe).touch(1, t.park, 0);
  ASSERT_FALSE(touch);
  EXPECT_NE(touch.error().message.find("needle"), std::string::npos) << touch.error().message;
}

/// Over a part's edge and down its side: a corner that is cut in space comes nearer to the edge than its legs do. What
/// is played is looked at, each tenth of a millimetre of it; the needle keeps at least a part of its gap, or the bead
/// is refused with both bodies.
TEST(Approaches, a_corner_that_is_cut_over_an_edge_keeps_the_needle_off_it) {
  Table t;
  t.recipe = test::dots(1, 1);  // no touches: where the part is is known
  const double height = 16, beside = 0.5;
  t.recipe.parts.push_back({.name = "U1", .at = {40, 30}, .size = {10, 10, height}, .location = {}});
  const auto needle = std::find_if(t.machine.head.begin(), t.machine.head.end(),
                                   [](const config::Body& body) { return body.name == "needle"; });
  ASSERT_NE(needle, t.machine.head.end());
  const double x = 45 + needle->shape.size.x / 2 + beside;
  recipes::Bead bead{.id = "down",
                     .points = {{40, 30, height}, {x, 30, height}, {x, 30, 4}},
                     .material = t.recipe.materials.front().name,
                     .location = {1, 1},
                     .on = "U1"};
  config::Body part;
  for (const config::Body& body : recipes::bodies(t.recipe, t.machine, {}, {}))
    if (body.name == "U1") part = body;
  for (const double tolerance : {0.0, 0.05, 0.2, 0.5, 1.0, 2.0, 3.0}) {
    bead.corner_tolerance = tolerance;
    t.recipe.features = {bead};
    const BlockPlanner planner(t.machine, t.recipe);
    const auto block = planner.dispense(1, t.park, {0});
    ASSERT_TRUE(block) << block.error().message;
    const motion::Scene scene(t.machine);
    for (const motion::Segment& piece : block->segments())
      for (double s = 0; s <= piece.geometry.length; s += 0.1) {
        config::Body there = *needle;
        for (const motion::SceneBody& head : scene.head())
          if (head.name == "needle")
            there.centre = there.centre + scene.carried(head, motion::point(piece.geometry, s));
        EXPECT_GE(test::distance(there, part), 0.19) << "tolerance " << tolerance;
      }
  }
}

/// Over a valley and a ridge the needle stays above what it dispenses on, and at its gap, whatever corner tolerance the
/// recipe allows: the drawn line is the surface.
TEST(Approaches, a_corner_that_is_rounded_up_and_down_keeps_the_gap) {
  Table t;
  t.recipe = test::dots(1, 1);
  recipes::Material& m = t.recipe.materials.front();
  m.gap = 0.2, m.gap_tolerance_mm = 0.08;
  const auto& needle = *config::find_tool(t.machine, "needle");
  for (const double tolerance : {0.05, 0.5, 2.0, 5.0}) {
    recipes::Bead bead{.id = "ridge",
                       .points = {{20, 30, 0}, {40, 30, 5}, {60, 30, 0}, {70, 30, 3}},
                       .corner_tolerance = tolerance,
                       .material = m.name,
                       .location = {1, 1}};
    t.recipe.features = {bead};
    const auto block = BlockPlanner(t.machine, t.recipe).dispense(1, t.park, {0});
    ASSERT_TRUE(block) << block.error().message;
    const auto surface_at = [&](double x) {
      for (std::size_t i = 1; i < bead.points.size(); ++i)
        if (x <= bead.points[i].x) {
          const Vec3 a = bead.points[i - 1], b = bead.points[i];
          return a.z + (b.z - a.z) * (x - a.x) / (b.x - a.x);
        }
      return bead.points.back().z;
    };
    const Vec3 origin = recipes::to_machine(t.recipe, t.machine, {}, {}, {0, 0}, 0);
    for (const motion::Segment& piece : block->segments()) {
      if (piece.feature != 0) continue;
      for (double s = 0; s <= piece.geometry.length; s += 0.05) {
        const AxisVec q = motion::point(piece.geometry, s);
        const double x = q[t.machine.x.value] + needle.tip.x - origin.x;
        if (x < 20 || x > 70) continue;
        const double z = q[t.machine.z.value] + needle.tip.z - origin.z;
        EXPECT_NEAR(z - needle.lift_mm - surface_at(x), m.gap, m.gap_tolerance_mm + 1e-6)
            << "tolerance " << tolerance << " x " << x;
      }
    }
  }
}

}  // namespace
}  // namespace gantry::job
