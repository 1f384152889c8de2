// What a bead that is planned too slow is told to change: what it has.
#include "app/job/slow_beads.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "motion/path/bead.hpp"
#include "tests/motion/machine.hpp"

namespace gantry::job {
namespace {

recipes::Recipe recipe() {
  return recipes::
      parse("version: 1\nrecipe: r\nplacement: fixture\nboard: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}\n"
            "materials:\n  a: {speed: 100 mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
            "dot_time: 60 ms, retract: 3 mm}\nfeatures:\n"
            "  - line: {name: straight, material: a, from: [10 mm, 10 mm], to: [14 mm, 13 mm]}\n"
            "  - polyline: {name: zig, material: a, points: [[20 mm, 10 mm], [23 mm, 13 mm], [26 mm, 10 mm]]}\n"
            "  - circle: {name: ring, material: a, centre: [40 mm, 30 mm], radius: 3 mm}\n",
            "r.yaml")
          .value();
}

config::Machine with(const motion::Limits& limits) {
  config::Machine machine;
  machine.x = AxisId{0}, machine.y = AxisId{1}, machine.z = AxisId{2};
  machine.bus.cycle = nanoseconds(std::llround(limits.tick_s * 1e9));
  for (std::uint8_t i = 0; i < limits.axes; ++i) {
    const motion::AxisLimits& l = limits.axis[i];
    config::Axis& axis = machine.axes.emplace_back();
    axis.id = AxisId{i}, axis.rotary = !limits.linear[i];
    axis.p_min = l.p_min, axis.p_max = l.p_max, axis.v_max = l.v_max, axis.a_max = l.a_max, axis.j_max = l.j_max;
    axis.response_delay_s = limits.response_delay_s[i];
  }
  return machine;
}

bool says(const std::string& text, const char* piece) { return text.find(piece) != std::string::npos; }

TEST(SlowBeads, a_straight_line_has_no_corner_to_round) {
  const auto r = recipe();
  const std::string never = in_words({.feature = 0, .asked_mm_s = 100, .fastest_mm_s = 60, .at_speed = 0.2}, r),
                    steady = in_words({.feature = 0, .asked_mm_s = 100, .steady_mm_s = 70.77, .fastest_mm_s = 71}, r);
  for (const std::string& text : {never, steady}) EXPECT_FALSE(says(text, "corner")) << text;
  EXPECT_TRUE(says(never, "the 5 mm of it are too short")) << never;
  EXPECT_TRUE(says(never, "a lower `speed`")) << never;
  EXPECT_TRUE(says(steady, "`speed: 70.7 mm/s`")) << steady;
  EXPECT_TRUE(says(steady, "flow_follows_speed")) << steady;
}

TEST(SlowBeads, corners_and_curves_are_told_what_would_help) {
  const auto r = recipe();
  EXPECT_TRUE(says(in_words({.feature = 1, .asked_mm_s = 100, .at_speed = 0.2}, r), "larger `corner_tolerance`"));
  EXPECT_TRUE(says(in_words({.feature = 1, .asked_mm_s = 100, .steady_mm_s = 60}, r), "larger `corner_tolerance`"));
  EXPECT_TRUE(says(in_words({.feature = 2, .asked_mm_s = 100, .steady_mm_s = 88}, r), "a larger radius"));
  EXPECT_TRUE(says(in_words({.feature = 2, .asked_mm_s = 100, .steady_mm_s = 0.5}, r), "`speed: 0.5 mm/s`"))
      << "never 0";
}

TEST(SlowBeads, that_begin_slowly_are_told_to_be_longer) {
  const auto r = recipe();
  for (const std::uint32_t feature : {0u, 1u, 2u}) {
    const std::string text =
        in_words({.feature = feature, .asked_mm_s = 100, .begins_slowly_mm_s = 8.6, .at_speed = 0.2}, r);
    EXPECT_TRUE(says(text, "begins at 8.6 mm/s")) << text;
    EXPECT_TRUE(says(text, "draw it longer")) << text;
    EXPECT_FALSE(says(text, "radius") || says(text, "corner")) << text;
  }
}

/// A line of this length at this speed, as the first feature of a recipe of that material.
std::vector<SlowBead> slow_line(double length_mm, double speed_mm_s, recipes::Recipe& r) {
  r.materials.front().speed = speed_mm_s;
  std::get<recipes::Bead>(r.features.front()).points = {{10, 10, 0}, {10 + length_mm, 10, 0}};
  const auto motion =
      motion::plan_bead(motion::test::machine(), {.points = {{200, 200, -50}, {200 + length_mm, 200, -50}},
                                                  .speed_mm_s = speed_mm_s,
                                                  .corner_tolerance_mm = 0.05,
                                                  .valve = 1,
                                                  .feature = 0});
  std::vector<SlowBead> slow;
  add_slow_beads(slow, r, {motion->segments.begin(), motion->segments.end()}, with(motion::test::machine()));
  return slow;
}

/// By hand: 0.301 mm at 20 mm/s are 15.05 ms, so 16 cycles, at 18.81 mm/s: 5.9 % too slow. 0.381 mm are 19.05 ms, so 20
/// cycles, 4.75 % too slow, and 5 % are allowed.
// Legs of 0.25 mm with a rest in each corner: at 5.7 mm/s the needle is at its speed for most of the way, and in no 0.4
// mm of it in the mean, so that the bead has too much everywhere.
TEST(SlowBeads, that_rest_in_near_corners_are_never_at_their_speed_in_the_mean) {
  auto r = recipe();
  r.materials.front().speed = 5.7;
  std::vector<AxisVec> points;
  for (int k = 0; k < 18; ++k) points.push_back({200 + 0.2425 * k, 200 + (k % 2) * 0.0625, -50});
  const auto motion =
      motion::plan_bead(motion::test::machine(), {.points = points, .speed_mm_s = 5.7, .valve = 1, .feature = 0});
  ASSERT_TRUE(motion);
  std::vector<SlowBead> slow;
  add_slow_beads(slow, r, {motion->segments.begin(), motion->segments.end()}, with(motion::test::machine()));
  ASSERT_EQ(slow.size(), 1u);
  EXPECT_LT(slow[0].at_speed, 0.1);
  EXPECT_FALSE(slow[0].begins_slowly_mm_s);
}

TEST(SlowBeads, what_whole_cycles_make_slower_is_known_by_its_cause) {
  auto r = recipe();
  for (const double length_mm : {0.3, 0.299, 0.381, 0.32, 2.0})
    EXPECT_TRUE(slow_line(length_mm, 20, r).empty()) << length_mm;
  const auto slow = slow_line(0.301, 20, r);
  ASSERT_EQ(slow.size(), 1u);
  EXPECT_NEAR(slow[0].lasts_s, 0.016, 1e-9);
  EXPECT_NEAR(slow[0].would_last_s, 0.01505, 1e-9);
  const std::string text = in_words(slow[0], r);
  EXPECT_TRUE(
      says(text, "goes at 18.8 mm/s instead of 20 mm/s: it takes whole cycles of 1 ms, 16 ms instead of 15.05 ms"))
      << text;
  EXPECT_TRUE(says(text, "`speed: 18.82 mm/s`")) << text;
  EXPECT_FALSE(says(text, "a_max")) << text;
  EXPECT_TRUE(slow_line(0.301, 18.82, r).empty()) << "the remedy helps";
}

/// By hand: at 24 mm/s on a radius of 0.8 mm a lag of 6 ms takes (v t / r)^2 / 2 = 1.6 % of the speed, one of 1 ms
/// 0.05 %, and 1 % may be missing.
TEST(SlowBeads, that_lagging_drives_may_slow_down_are_told_as_such) {
  auto r = recipe();
  auto& bead = std::get<recipes::Bead>(r.features[0]);
  r.materials.front().speed = 24, r.materials.front().speed_tolerance = 0.01;
  std::vector<AxisVec> points;
  constexpr double kRadius = 0.8;
  for (int k = 0; k <= 200; ++k) {
    const double turn = 2 * std::numbers::pi * k / 200;
    points.push_back({300 + kRadius * std::cos(turn), 200 + kRadius * std::sin(turn), -50});
  }
  for (const AxisVec& q : points) bead.points.push_back({q[0], q[1], 0});
  auto limits = motion::test::machine();
  const auto motion = motion::plan_bead(
      limits, {.points = points, .speed_mm_s = 24, .corner_tolerance_mm = 0.005, .valve = 1, .feature = 0});
  ASSERT_TRUE(motion);
  for (const auto& [delay_s, told] : {std::pair{0.0, false}, {0.001, false}, {0.006, true}}) {
    limits.response_delay_s.fill(delay_s);
    std::vector<SlowBead> slow;
    add_slow_beads(slow, r, {motion->segments.begin(), motion->segments.end()}, with(limits));
    ASSERT_EQ(slow.size(), told ? 1u : 0u) << delay_s;
    if (!told) continue;
    EXPECT_TRUE(slow[0].narrowly);
    EXPECT_TRUE(says(in_words(slow[0], r), "the drives' lag takes 1.7 % of the speed")) << in_words(slow[0], r);
    EXPECT_NEAR(slow[0].steady_mm_s, 24 * std::sqrt(0.9 * 0.01 / 0.0162), 0.4) << "what would do";
  }
}

std::vector<SlowBead> polyline(std::vector<Vec3> points, double corner_tolerance_mm, recipes::Recipe& r,
                               double speed_mm_s = 20, const motion::Limits& limits = motion::test::machine()) {
  auto& bead = std::get<recipes::Bead>(r.features[1]);
  bead.points = std::move(points), bead.corner_tolerance = corner_tolerance_mm;
  motion::BeadSpec spec;
  spec.speed_mm_s = speed_mm_s, spec.corner_tolerance_mm = corner_tolerance_mm, spec.valve = 1;
  for (const Vec3 p : bead.points) spec.points.push_back({p.x + 200, p.y + 200, -50});
  r.materials.front().speed = speed_mm_s;
  const auto motion = motion::plan_bead(limits, spec);
  EXPECT_TRUE(motion) << speed_mm_s;
  if (!motion) return {};
  std::deque<motion::Segment> segments(motion->segments.begin(), motion->segments.end());
  for (auto& s : segments) s.feature = 1;
  std::vector<SlowBead> slow;
  add_slow_beads(slow, r, segments, with(limits));
  return slow;
}

/// A zigzag whose corners no path passes without a stop: 0.3 um are no tolerance (docs/motion/path.md).
std::vector<SlowBead> zigzag(double corner_tolerance_mm, recipes::Recipe& r) {
  return polyline({{20, 10, 0}, {32, 10, 0}, {32, 22, 0}, {44, 22, 0}}, corner_tolerance_mm, r);
}

TEST(SlowBeads, a_corner_that_leads_straight_back_is_no_fault_of_the_plan) {
  auto r = recipe();
  EXPECT_TRUE(polyline({{20, 10, 0}, {44, 10, 0}, {20, 10, 0}}, 0.1, r).empty());
  EXPECT_EQ(reversals(std::get<recipes::Bead>(r.features[1])), 1u);
}

TEST(SlowBeads, one_that_stands_with_its_valve_open_is_told_unless_the_recipe_asks_for_it) {
  auto r = recipe();
  EXPECT_TRUE(zigzag(0, r).empty()) << "0 asks for a stop in each corner";
  EXPECT_TRUE(zigzag(0.1, r).empty());
  const auto slow = zigzag(3e-4, r);
  ASSERT_EQ(slow.size(), 1u);
  EXPECT_EQ(slow[0].feature, 1u);
  EXPECT_EQ(slow[0].stands, 2u);
  EXPECT_NEAR(slow[0].stands_at_mm, 12, 1e-6);
  const std::string text = in_words(slow[0], r);
  EXPECT_TRUE(says(text, "stands still 2 times with its valve open, first 12 mm from where that opens")) << text;
  EXPECT_TRUE(says(text, "`corner_tolerance` of 0.0003 mm; write a larger one")) << text;
  r.materials.front().flow_follows_speed = true;
  EXPECT_TRUE(zigzag(3e-4, r).empty());
}

/// A machine whose X and Y are alike.
motion::Limits alike(double a_max, double j_max) {
  motion::Limits limits = motion::test::machine();
  for (const std::size_t i : {0u, 1u}) limits.axis[i].a_max = a_max, limits.axis[i].j_max = j_max;
  return limits;
}

constexpr std::pair<double, double> kAxes[] = {
    {600, 15000}, {1500, 20000}, {3000, 50000}, {4000, 80000}, {8000, 400000}};

/// However deep it is, and however long it lasts for that: each leg is long enough to come to the speed again.
TEST(SlowBeads, a_corner_is_none_whatever_its_angle_its_tolerance_its_speed_and_its_axes) {
  std::mt19937_64 random(15);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int n = 0; n < 100; ++n) {
    const auto& [a_max, j_max] = kAxes[static_cast<std::size_t>(n) % std::size(kAxes)];
    const double speed = std::pow(10, draw(0.3, a_max < 1000 ? 1.7 : 2.1)), tolerance = std::pow(10, draw(-2.5, 0));
    const double leg = 6 * speed * (speed / a_max + std::sqrt(speed / j_max)) + 20 * tolerance + 3;
    auto r = recipe();
    std::vector<Vec3> points{{10, 10, 0}};
    double heading = draw(0, 0.5);
    for (int k = 0; k < 3; ++k) {
      points.push_back(points.back() + Vec3{leg * std::cos(heading), leg * std::sin(heading), 0});
      heading += draw(0.1, 3.0) * (k % 2 == 0 ? 1 : -1);
    }
    for (const SlowBead& each : polyline(points, tolerance, r, speed, alike(a_max, j_max)))
      ADD_FAILURE() << "case " << n << ", tolerance " << tolerance << ": " << in_words(each, r);
  }
}

/// One corner, slow and of a small tolerance: a mean over 0.4 mm is the same for all that hold the corner.
TEST(SlowBeads, a_corner_is_none_at_a_low_speed_and_a_small_tolerance) {
  for (const double tolerance : {0.01, 0.02, 0.05})
    for (const double speed : {2.0, 4.0, 6.0, 8.0, 10.0, 12.0})
      for (const double degrees : {50.0, 90.0, 120.0, 150.0})
        for (const double rounds : {0.02, 0.1, 0.3}) {
          auto r = recipe();
          r.materials.front().speed_tolerance = tolerance;
          const double turn = degrees * std::numbers::pi / 180;
          const Vec3 corner{40, 10, 0};
          const auto slow = polyline({{10, 10, 0}, corner, corner + Vec3{30 * std::cos(turn), 30 * std::sin(turn), 0}},
                                     rounds, r, speed, alike(4000, 80000));
          EXPECT_TRUE(slow.empty()) << speed << " mm/s, " << degrees << " deg, " << rounds << " mm, " << tolerance
                                    << ": " << in_words(slow[0], r);
        }
}

/// Seven bends of 1 mm radius at 80 mm/s, one behind the other: the root of a r is 63 mm/s, and it never comes back to
/// its speed between them. Drawn in chords, without a corner.
TEST(SlowBeads, a_snake_too_narrow_for_its_speed_is_told_with_its_radius) {
  std::vector<Vec3> points{{10, 30, 0}, {35, 30, 0}};
  double heading = 0;
  const auto go = [&](double turn, int chords) {
    for (int k = 0; k < chords; ++k) {
      heading += turn / chords;
      points.push_back(points.back() + Vec3{0.1 * std::cos(heading), 0.1 * std::sin(heading), 0});
    }
  };
  go(0.75, 8);
  for (int n = 0; n < 7; ++n) go(n % 2 == 0 ? -1.5 : 1.5, 15);
  go(0.75, 8);
  points.push_back(points.back() + Vec3{25, 0, 0});
  auto r = recipe();
  const auto slow = polyline(points, 0.05, r, 80, alike(4000, 80000));
  ASSERT_EQ(slow.size(), 1u);
  EXPECT_LT(slow[0].steady_mm_s, 64);
  EXPECT_GT(slow[0].sags_s, 0.15);
  EXPECT_TRUE(says(in_words(slow[0], r), "slows down to")) << in_words(slow[0], r);
  EXPECT_TRUE(says(in_words(slow[0], r), "its curve, radius")) << in_words(slow[0], r);
}

/// By hand: on a radius r an axis that may accelerate by a goes at no more than sqrt(a r), and one whose jerk may be j
/// at no more than the cube root of j r^2.
TEST(SlowBeads, a_spiral_too_narrow_for_its_speed_at_its_inner_end_is_told_that_and_not_where_it_is_slow_enough) {
  int told = 0;
  for (const auto& [a_max, j_max] : kAxes)
    for (const double inner : {0.5, 2.0})
      for (const bool inwards : {false, true}) {
        constexpr double kSpacing = 1, kOuter = 6;
        std::vector<Vec3> points;
        const double turns = (kOuter - inner) / kSpacing;
        const int n = static_cast<int>(turns * 90);
        for (int k = 0; k <= n; ++k) {
          const double share = inwards ? 1 - static_cast<double>(k) / n : static_cast<double>(k) / n;
          const double radius = inner + (kOuter - inner) * share, turn = 2 * std::numbers::pi * turns * share;
          points.push_back({60 + radius * std::cos(turn), 40 + radius * std::sin(turn), 0});
        }
        const double at_most = std::min(std::sqrt(a_max * inner), std::cbrt(j_max * inner * inner));
        auto r = recipe();
        std::get<recipes::Bead>(r.features[1]).curve_mm = 1e-3;
        EXPECT_TRUE(polyline(points, 0.05, r, 0.7 * at_most, alike(a_max, j_max)).empty())
            << a_max << " " << inner << " " << inwards;
        const double faster = 1.5 * at_most;
        const auto slow = polyline(points, 0.05, r, faster, alike(a_max, j_max));
        for (const SlowBead& each : slow) {
          ++told;
          EXPECT_LT(each.steady_mm_s, 0.95 * faster);
          EXPECT_GT(each.steady_mm_s, 0.6 * at_most);
          EXPECT_TRUE(says(in_words(each, r), "radius")) << in_words(each, r);
        }
        // By hand: 50 ms and one and a half times two changes of the speed by a half of what is at most.
        const double change = 2 * std::sqrt(0.5 * at_most / j_max) + 0.5 * at_most / a_max;
        const double narrow_mm = std::numbers::pi * (2.25 - 1) * inner * inner / kSpacing;  // to 1.5^2 of the radius
        EXPECT_TRUE(narrow_mm / faster < 0.1 + 3 * change || !slow.empty()) << a_max << " " << inner << " " << inwards;
      }
  EXPECT_GE(told, 8);
}

}  // namespace
}  // namespace gantry::job
