#include "app/job/block_plan.hpp"

#include <gtest/gtest.h>
#include <set>

#include "motion/geometry.hpp"
#include "motion/path/moves.hpp"
#include "motion/profile/speed_profile.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

constexpr const char* kMarks =
    "marks:\n  m0: {at: [5 mm, 6 mm], diameter: 1.5 mm}\n  m1: {at: [70 mm, 45 mm], diameter: 1.5 mm}\n";
constexpr const char* kTouches =
    "touches:\n  t0: {at: [10 mm, 10 mm]}\n  t1: {at: [70 mm, 10 mm]}\n  t2: {at: [40 mm, 45 mm]}\n";

struct BlockPlanTest : testing::Test {
  config::Machine machine = test::reference();
  recipes::Recipe recipe = test::dots(2, 3, std::string(kMarks) + kTouches);
  AxisVec park = test::parked(machine);

  [[nodiscard]] Vec3 tip(const char* tool, const AxisVec& q) const {
    const config::Tool& t = *config::find_tool(machine, tool);
    return {q[machine.x.value] + t.tip.x, q[machine.y.value] + t.tip.y,
            q[machine.z.value] + t.tip.z - (machine.u ? q[machine.u->value] : 0)};
  }
  /// Where a point of the board is, worked out here.
  [[nodiscard]] Vec3 on_board(Vec2 p, double height, const Knowledge& known) const {
    const config::WorkFrame& frame = *config::find_frame(machine, recipe.board.frame);
    const recipes::WorkOffset o = known.offset.value_or(recipes::WorkOffset{});
    const Vec2 turned{p.x * std::cos(o.rotation) - p.y * std::sin(o.rotation) + o.shift.x + recipe.board.at.x,
                      p.x * std::sin(o.rotation) + p.y * std::cos(o.rotation) + o.shift.y + recipe.board.at.y};
    const recipes::Surface s = known.surface.value_or(recipes::Surface{});
    return {frame.origin.x + turned.x, frame.origin.y + turned.y,
            frame.origin.z + recipe.board.thickness + s.z0 + s.slope.x * p.x + s.slope.y * p.y + height};
  }
};

TEST_F(BlockPlanTest, the_camera_looks_where_the_guess_says_and_exposes_at_rest) {
  BlockPlanner planner(machine, recipe);
  Knowledge known;
  known.guess = {{1.5, -2}, 0.01};
  planner.know(known);
  const auto block = planner.look_at_mark(4, park, 1);
  ASSERT_TRUE(block) << to_text(block.error());
  Knowledge as_offset;
  as_offset.offset = known.guess;
  const Vec3 want = on_board(recipe.marks[1].at, 0, as_offset), is = tip("camera", block->end());
  EXPECT_NEAR(is.x, want.x, 1e-9);
  EXPECT_NEAR(is.y, want.y, 1e-9);
  int exposures = 0;
  for (const motion::Segment& s : block->segments())
    for (const motion::OutputEvent& e : s.events) {
      EXPECT_EQ(s.kind, motion::SegmentKind::Dwell);
      EXPECT_EQ(e.mask & config::bit(config::Output::Valve), 0u);
      exposures += (e.value & config::bit(config::Output::CameraTrigger)) != 0;
    }
  EXPECT_EQ(exposures, 1);
}

TEST_F(BlockPlanTest, dots_are_dispensed_in_the_gap_over_the_measured_surface) {
  BlockPlanner planner(machine, recipe);
  Knowledge known;
  known.offset = recipes::WorkOffset{{0.8, -1.1}, 0.012};
  known.surface = recipes::Surface{0.3, {0.002, -0.003}};
  planner.know(known);
  const std::vector<std::size_t> some{1, 4};
  const auto block = planner.dispense(9, park, some);
  ASSERT_TRUE(block) << to_text(block.error());
  std::vector<std::size_t> seen;
  for (const motion::Segment& s : block->segments()) {
    if (s.feature == motion::kTravel) continue;
    seen.push_back(s.feature);
    const Vec3 is = tip("needle", s.geometry.from);
    const Vec3 want = on_board(std::get<recipes::Dot>(recipe.features[s.feature]).at, recipe.materials[0].gap, known);
    // The tool's own lift lowers it: tip() counts U, as the machine does.
    EXPECT_NEAR(is.x, want.x, 1e-9);
    EXPECT_NEAR(is.y, want.y, 1e-9);
    EXPECT_NEAR(is.z, want.z, 1e-9);
  }
  EXPECT_EQ(seen, some);
}

/// The needle is over its dot, and goes straight down to it, when the valve is told to open; however long the lead.
TEST_F(BlockPlanTest, the_valve_is_told_to_open_when_nothing_goes_across_any_more) {
  for (const double lead_s : {0.0, 0.02, 0.06, 0.08, 0.1, 0.11}) {
    recipe.materials.front().settle_time = 0;
    recipe.materials.front().retract = 3;
    recipe.materials.front().valve_open_lead = lead_s;
    BlockPlanner planner(machine, recipe);
    const auto block = planner.dispense(9, park, {0, 1, 2, 3, 4, 5});
    ASSERT_TRUE(block) << to_text(block.error());
    const auto at = [&](double t) {
      for (const motion::Segment& s : block->segments()) {
        const double lasts = motion::duration({&s, 1});
        if (t <= lasts) return motion::point(s.geometry, motion::along(s.nominal, t).x.p);
        t -= lasts;
      }
      return block->end();
    };
    double begins = 0;
    int told = 0;
    for (const motion::Segment& s : block->segments()) {
      for (const motion::OutputEvent& e : s.events) {
        if (!e.dispense) continue;
        const AxisVec then = at(begins + e.at_s - e.lead_s), there = at(begins + e.at_s);
        EXPECT_NEAR(then[machine.x.value], there[machine.x.value], 1e-9) << lead_s;
        EXPECT_NEAR(then[machine.y.value], there[machine.y.value], 1e-9) << lead_s;
        ++told;
      }
      begins += motion::duration({&s, 1});
    }
    EXPECT_EQ(told, 6);
  }
}

TEST_F(BlockPlanTest, the_probe_goes_through_the_window_and_comes_back_up) {
  BlockPlanner planner(machine, recipe);
  Knowledge known;
  known.offset = recipes::WorkOffset{{0.5, 0.5}, 0};
  planner.know(known);
  const auto block = planner.touch(2, park, 1);
  ASSERT_TRUE(block) << to_text(block.error());
  const motion::Segment& down = block->segments().back();
  EXPECT_EQ(down.kind, motion::SegmentKind::UntilProbe);
  const Vec3 from = tip("probe", motion::point(down.geometry, 0)),
             to = tip("probe", motion::point(down.geometry, down.geometry.length));
  const Vec3 surface = on_board(recipe.touches[1].at, 0, known);
  EXPECT_GE(from.z, surface.z + recipe.touch_rules.window_mm);
  EXPECT_LE(to.z, surface.z - recipe.touch_rules.window_mm + 1e-9);
  const auto up = planner.retract(3, motion::point(down.geometry, down.geometry.length / 2), 1);
  ASSERT_TRUE(up) << to_text(up.error());
  EXPECT_GT(up->end()[machine.z.value], motion::point(down.geometry, down.geometry.length / 2)[machine.z.value]);
}

/// Over the bead that is fresh the needle goes back in one motion: by time, that of the length at the speed of the bead
/// and of setting out and stopping once; by place, on the circle's last part. Where it rises it stands over the bead's
/// end first.
TEST_F(BlockPlanTest, back_along_a_curve_goes_one_path_that_does_not_stop_over_it) {
  constexpr double kRadius_mm = 6, kBack_mm = 15, kOff_mm = 0.05;
  for (const double lift_mm : {0.0, 1.0}) {
    recipes::Material& m = recipe.materials.front();
    m.back_track = kBack_mm, m.tail_lift = lift_mm, m.speed = 20;
    recipes::Bead ring{"ring", {}, true, kOff_mm, m.name, m.location, "circle", 0};
    for (int i = 0; i <= 48; ++i)
      ring.points.push_back({40 + kRadius_mm * std::cos(i * M_PI / 24), 25 + kRadius_mm * std::sin(i * M_PI / 24), 0});
    ring.points.back() = ring.points.front();
    recipe.features = {ring};
    recipe.touches.clear();
    BlockPlanner planner(machine, recipe);
    planner.know({});
    const auto block = planner.dispense(9, park, {0});
    ASSERT_TRUE(block) << to_text(block.error());
    const auto& segments = block->segments();
    std::size_t first = segments.size();
    while (segments[first - 1].feature == motion::kTravel) --first;
    // From the run-out's end back along the bead to where it rises straight.
    const Vec3 centre = on_board({40, 25}, m.gap, {});
    double seconds = 0, length_mm = 0;
    int rests = 0;
    for (std::size_t k = first; k < segments.size(); ++k) {
      const motion::Segment& s = segments[k];
      const Vec3 from = tip("needle", motion::point(s.geometry, 0)),
                 to = tip("needle", motion::point(s.geometry, s.geometry.length));
      if (norm(flat(to) - flat(from)) < 1e-9) break;
      seconds += motion::duration(s.nominal), length_mm += s.geometry.length, rests += s.rests;
      for (int i = 0; i <= 10; ++i) {
        const Vec3 at = tip("needle", motion::point(s.geometry, s.geometry.length * i / 10));
        EXPECT_GE(at.z - centre.z, -1e-6) << "never nearer to the bead than it was laid";
        const double angle = std::atan2(at.y - centre.y, at.x - centre.x);
        if (angle > 0) continue;  // the run-out is straight
        EXPECT_NEAR(std::hypot(at.x - centre.x, at.y - centre.y), kRadius_mm, kOff_mm);
        EXPECT_NEAR(at.z - centre.z, lift_mm * -angle * kRadius_mm / kBack_mm, 2 * kOff_mm);
      }
    }
    EXPECT_EQ(rests, lift_mm > 0 ? 2 : 1) << "at its end";
    EXPECT_GT(length_mm, kBack_mm);
    EXPECT_LT(length_mm, kBack_mm + 1.5) << "and the run-out";
    EXPECT_LT(seconds, length_mm / 20 + rests * 0.08) << "2 sqrt(v/j) = 32 ms for setting out, as much for stopping";
  }
}

TEST_F(BlockPlanTest, the_same_question_has_the_same_answer_on_every_planner) {
  const auto plan = [&] {
    BlockPlanner planner(machine, recipe);
    Knowledge known;
    known.offset = recipes::WorkOffset{{0.8, -1.1}, 0.012};
    known.surface = recipes::Surface{};
    planner.know(known);
    return planner.dispense(9, park, {0, 1, 2, 3, 4, 5});
  };
  const auto a = plan(), b = plan();
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->segments().size(), b->segments().size());
  for (std::size_t i = 0; i < a->segments().size(); ++i) {
    EXPECT_EQ(a->segments()[i].geometry.from, b->segments()[i].geometry.from);
    EXPECT_EQ(a->segments()[i].geometry.c, b->segments()[i].geometry.c);
    EXPECT_EQ(a->segments()[i].v_cap, b->segments()[i].v_cap);
  }
}

TEST_F(BlockPlanTest, an_error_names_the_feature_and_its_line) {
  recipe.parts.push_back({.name = "U9", .at = {10, 10}, .size = {6, 6, 5}, .location = {}});
  BlockPlanner planner(machine, recipe);
  const auto block = planner.dispense(1, park, {0});
  ASSERT_FALSE(block);
  EXPECT_EQ(block.error().fault, Fault::Collision);
  EXPECT_NE(block.error().message.find("U9"), std::string::npos) << block.error().message;
  EXPECT_NE(block.error().message.find("dot '"), std::string::npos) << block.error().message;
  EXPECT_EQ(block.error().where.find("dots.yaml:"), 0u) << block.error().where;
}

}  // namespace
}  // namespace gantry::job
