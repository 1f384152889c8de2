// How much higher than its touches say a board may be. The judge draws boards that the recipe allows, touches them with
// errors that the probe may have, and looks where they truly are.
#include "recipes/surface_doubt.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "app/job/block_plan.hpp"
#include "app/job/settle.hpp"
#include "app/job/surroundings.hpp"
#include "core/units.hpp"
#include "motion/geometry.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

constexpr Vec2 kBoard_mm{80, 55};

/// A dot at `at` with this gap on a board of 80 x 55 mm that is touched at these points.
Result<recipes::Recipe> dot_on_board(const std::vector<Vec2>& touches, Vec2 at, double gap_mm,
                                     const std::string& rules = "") {
  std::string text =
      "version: 1\nrecipe: one\nplacement: fixture\n"
      "board: {size: [80 mm, 55 mm], thickness: 12 mm, frame: pallet}\n";
  if (!touches.empty()) text += "touches:\n";
  for (std::size_t i = 0; i < touches.size(); ++i)
    text += fmt::format("  t{}: {{at: [{} mm, {} mm]}}\n", i, touches[i].x, touches[i].y);
  text += rules;
  text += fmt::format(
      "materials:\n  glue: {{speed: 20 mm/s, gap: {} mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 30 "
      "ms, settle_time: 10 ms, retract: 3 mm}}\nfeatures:\n  - dot: {{name: far, material: glue, at: [{} mm, {} "
      "mm]}}\n",
      gap_mm, at.x, at.y);
  auto recipe = recipes::parse(text, "one.yaml");
  if (!recipe) return tl::unexpected(recipe.error().front());
  return *std::move(recipe);
}

TEST(SurfaceDoubt, no_board_that_the_recipe_allows_is_higher_and_some_board_is_as_high) {
  const config::Machine machine = test::reference();
  const double touch_mm = machine.probe.speed_mm_s * 1e-3 + 1 / machine.axes[machine.z.value].counts_per_unit;
  std::mt19937_64 random(20261125);
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  double nearest_to_bound = 0;
  for (int round = 0; round < 2000; ++round) {
    SCOPED_TRACE(round);
    const int count = 1 + round % 4;
    recipes::Recipe recipe = test::dots(1, 1);
    recipe.touch_rules.max_residual_mm = 5;
    const double spread = round % 3 == 0 ? 3 : 1000;  // some lie close together
    const Vec2 about{real(5, 75), real(5, 50)};
    for (int i = 0; i < count; ++i)
      recipe.touches.push_back({.name = fmt::format("t{}", i),
                                .at = {std::clamp(about.x + real(-spread, spread), 1.0, 79.0),
                                       std::clamp(about.y + real(-spread, spread), 1.0, 54.0)},
                                .location = {}});
    const double most = units::rad(real(0.01, 1));
    recipe.touch_rules.max_tilt_rad = most;
    const recipes::SurfaceDoubt doubt(recipe, machine);
    recipe.touch_rules.max_tilt_rad = units::rad(45);  // what close touches measure is not the question here
    for (int board = 0; board < 40; ++board) {
      const Vec2 slope = rotated({std::tan(most), 0}, real(-M_PI, M_PI)) * (board % 2 == 0 ? 1 : real(0, 1));
      const double z0 = real(-1, 1);
      std::vector<TouchedHeight> heights;
      for (std::size_t i = 0; i < recipe.touches.size(); ++i)
        heights.push_back({i, z0 + dot(slope, recipe.touches[i].at) + touch_mm * (board % 4 == 1 ? 0 : real(-1, 1))});
      const auto fit = settle_surface(recipe, heights);
      ASSERT_TRUE(fit) << to_text(fit.error());
      for (int k = 0; k < 10; ++k) {
        const Vec2 p{real(0, kBoard_mm.x), real(0, kBoard_mm.y)};
        const double higher = z0 + dot(slope, p) - fit->at(p);
        EXPECT_LE(higher, doubt.mm(p) + recipes::kHeightSlack_mm + 1e-9);
        if (doubt.tilt_unmeasured() && doubt.distance_mm(p) > 20)
          nearest_to_bound = std::max(nearest_to_bound, higher / (doubt.mm(p) + recipes::kHeightSlack_mm));
      }
    }
  }
  EXPECT_GT(nearest_to_bound, 0.9) << "the bound says more than there is";
}

TEST(SurfaceDoubt, check_names_the_feature_its_line_and_what_would_help) {
  const config::Machine machine = test::reference();
  const auto judged = [&](const std::vector<Vec2>& touches, double gap_mm, const std::string& rules = "") {
    const auto recipe = dot_on_board(touches, {75, 50}, gap_mm, rules);
    EXPECT_TRUE(recipe) << to_text(recipe.error());
    const auto job = recipes::compile(*recipe, machine);
    return job ? std::string() : to_text(job.error().front());
  };
  // 0.15 deg over the 80.6 mm from (5, 10) to (75, 50) are 0.211 mm.
  const std::string one = judged({{5, 10}}, 0.25);
  for (const char* word : {"one.yaml:10:5", "dot 'far'", "0.211 mm higher", "max_tilt", "0.15 deg", "two touches",
                           "80.6 mm away", "within 76.4 mm"})
    EXPECT_NE(one.find(word), std::string::npos) << word << " in: " << one;
  EXPECT_EQ(judged({{5, 10}}, 0.27), "");
  EXPECT_EQ(judged({{5, 10}}, 0.25, "touch_rules: {max_tilt: 0.1 deg}\n"), "");
  EXPECT_NE(judged({{5, 10}}, 0.5, "touch_rules: {max_tilt: 0.5 deg}\n"), "");
  EXPECT_EQ(judged({{5, 10}, {70, 10}, {10, 50}}, 0.25, "touch_rules: {max_tilt: 0.5 deg}\n"), "");
  // Across a line along X through y = 10 the dot is 40 mm away: 0.105 mm.
  const std::string two = judged({{5, 10}, {70, 10}}, 0.15);
  for (const char* word : {"0.105 mm higher", "a touch beside their line", "40 mm away"})
    EXPECT_NE(two.find(word), std::string::npos) << word << " in: " << two;
  EXPECT_EQ(judged({{5, 10}, {70, 10}}, 0.16), "");
  // They measure a tilt, but not well: 5.5 um over 2 mm are 0.2 mm over 80 mm.
  const std::string close = judged({{5, 10}, {7, 10}, {6, 12}}, 0.2);
  EXPECT_NE(close.find("farther apart"), std::string::npos) << close;
  // Without a touch the recipe states that the board is as drawn.
  EXPECT_EQ(judged({}, 0.1), "");
}

/// The syringe's lower end is 25 mm over the needle's tip. A part under its rim is free up to the clearance below that,
/// less what the board may be higher at the part's farthest corner.
TEST(SurfaceDoubt, a_part_is_taken_to_be_higher_where_the_tilt_is_not_measured) {
  const config::Machine machine = test::reference();
  auto recipe = *dot_on_board({{5, 10}}, {20, 20}, 0.5, "touch_rules: {max_tilt: 0.5 deg}\n");
  const double higher = std::tan(units::rad(0.5)) * std::hypot(20 + 12 + 1 - 5, 20 + 1 - 10);
  for (const double off : {-0.001, 0.001}) {
    recipe.parts = {{.name = "tall",
                     .at = {20 + 12, 20},
                     .size = {2, 2, 0.5 + 25 - machine.clearance_mm - higher + off},
                     .location = {}}};
    BlockPlanner planner(machine, recipe);
    Knowledge known;
    known.offset = recipes::WorkOffset{}, known.surface = recipes::Surface{};
    planner.know(known);
    const auto block = planner.dispense(1, test::parked(machine), {0});
    EXPECT_EQ(block.has_value(), off < 0) << off;
    if (!block) {
      EXPECT_NE(block.error().message.find("tall"), std::string::npos) << block.error().message;
    }
  }
}

/// A bead that goes to where the board is known well enough runs out to where it is not.
TEST(SurfaceDoubt, what_goes_beyond_a_feature_stays_over_the_board_as_well) {
  const config::Machine machine = test::reference();
  recipes::Recipe recipe = *dot_on_board({{5, 10}}, {20, 20}, 0.2, "touch_rules: {max_tilt: 0.5 deg}\n");
  recipe.materials.front().speed = 100;
  recipe.features = {
      recipes::Bead{.id = "seam", .points = {{5, 10, 0}, {21.5, 10, 0}}, .material = "glue", .location = {9, 5}}};
  const recipes::SurfaceDoubt doubt(recipe, machine);
  ASSERT_FALSE(recipes::reaches_board(recipe, doubt, recipe.features.front()));
  BlockPlanner planner(machine, recipe);
  Knowledge known;
  known.offset = recipes::WorkOffset{}, known.surface = recipes::Surface{};
  planner.know(known);
  const auto slow = planner.dispense(1, test::parked(machine), {0});
  EXPECT_TRUE(slow) << to_text(slow.error());
  // At 500 mm/s the run-out is longer than what is left of the gap allows.
  recipe.materials.front().speed = 400;
  BlockPlanner faster(machine, recipe);
  faster.know(known);
  const auto fast = faster.dispense(1, test::parked(machine), {0});
  ASSERT_FALSE(fast);
  EXPECT_NE(fast.error().message.find("bead 'seam'"), std::string::npos) << to_text(fast.error());
  EXPECT_NE(fast.error().message.find("board"), std::string::npos) << to_text(fast.error());
  EXPECT_EQ(fast.error().where, "one.yaml:9:5");
}

/// A bead that rises is come to from below: its run-up stays as high over a board that slopes as over one that is
/// level, where it keeps the gap but for 0.05 mm. By hand: 60 mm/s take 1.57 mm, the bead climbs by 0.32 of that, so
/// that the whole one of 0.5 mm would end on the board.
TEST(SurfaceDoubt, a_run_up_keeps_the_same_height_over_a_board_that_slopes) {
  const config::Machine machine = test::reference();
  recipes::Recipe recipe =
      *dot_on_board({{5, 10}, {75, 12}, {8, 45}}, {20, 20}, 0.5, "touch_rules: {max_tilt: 4 deg}\n");
  recipe.materials.front().speed = 60;
  recipe.features = {
      recipes::Bead{.id = "climb", .points = {{30, 20, 0}, {38, 24, 3}}, .material = "glue", .location = {9, 5}}};
  const Vec3 needle = config::find_tool(machine, "needle")->tip;
  for (const Vec2 slope : {Vec2{0, 0}, Vec2{0.0122, -0.014}, Vec2{0.05, 0}, Vec2{-0.05, 0}, Vec2{0, 0.05}}) {
    Knowledge known;
    known.offset = recipes::WorkOffset{}, known.surface = recipes::Surface{.z0 = 0, .slope = slope};
    BlockPlanner planner(machine, recipe);
    planner.know(known);
    const auto block = planner.dispense(1, test::parked(machine), {0});
    ASSERT_TRUE(block) << to_text(block.error());
    const Vec3 corner = recipes::to_machine(recipe, machine, {}, *known.surface, {0, 0}, 0);
    double lowest_mm = 1e9;
    for (const motion::Segment& segment : block->segments())
      for (int i = 0; segment.kind != motion::SegmentKind::Dwell && i <= 100; ++i) {
        const AxisVec q = motion::point(segment.geometry, segment.geometry.length * i / 100);
        const double z = q[machine.z.value] - q[machine.u->value];
        const Vec3 tip = needle + Vec3{q[machine.x.value], q[machine.y.value], z} - corner;
        lowest_mm = std::min(lowest_mm, tip.z - slope.x * tip.x - slope.y * tip.y);
      }
    EXPECT_GE(lowest_mm, 0.45 - 1e-3) << slope.x << ' ' << slope.y;
    ASSERT_EQ(block->run_ups().size(), 1u) << slope.x << " " << slope.y << ", lowest " << lowest_mm;
    EXPECT_EQ(block->run_ups().front().kind, RunUp::Kind::Shorter);
  }
}

TEST(SurfaceDoubt, a_measured_tilt_beyond_the_rule_is_refused) {
  auto recipe = *dot_on_board({{5, 10}, {70, 10}, {10, 50}}, {20, 20}, 0.5, "touch_rules: {max_tilt: 0.3 deg}\n");
  for (const double deg : {0.29, 0.31}) {
    const double slope = std::tan(units::rad(deg));
    const auto fit = settle_surface(recipe, {{0, slope * 5}, {1, slope * 70}, {2, slope * 10}});
    EXPECT_EQ(fit.has_value(), deg < 0.3);
    if (!fit) {
      EXPECT_EQ(fit.error().fault, Fault::HeightsDisagree);
      EXPECT_NE(fit.error().message.find("max_tilt"), std::string::npos);
      EXPECT_NE(fit.error().where.find("one.yaml:"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace gantry::job
