#include "motion/path/bead.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>

#include "motion/path/moves.hpp"
#include "motion/path/sound.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/speed_profile.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/path/a_bead.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion {
namespace {

using test::at;
using test::limit_use;
using test::machine;
using test::path_state;
using test::spec_of;

constexpr unsigned kSeed = 11;

/// Everything that any bead has to be.
void check_bead(const Limits& m, const BeadSpec& spec, const BeadMotion& bead, const std::string& what) {
  // Boundaries: position, direction, curvature, speed and acceleration go on.
  AxisVec end = bead.start;
  test::PathState last;
  for (std::size_t k = 0; k < bead.segments.size(); ++k) {
    const Segment& s = bead.segments[k];
    ASSERT_EQ(s.kind, SegmentKind::Piece);
    ASSERT_NEAR(s.nominal.v0, static_cast<double>(last.v), 1e-7 * spec.speed_mm_s) << k << what;
    ASSERT_NEAR(s.nominal.a0, static_cast<double>(last.a), 1e-3) << k << what;
    const bool rested = k == 0 || bead.segments[k - 1].rests;
    for (std::size_t i = 0; i < m.axes; ++i) {
      ASSERT_NEAR(point(s.geometry, 0)[i], end[i], 1e-9) << k << what;
      if (rested) continue;  // a corner with a rest has no common tangent
      const Geometry& before = bead.segments[k - 1].geometry;
      ASSERT_NEAR(derivative<1>(s.geometry, 0)[i], derivative<1>(before, before.length)[i], 1e-5) << k << what;
      const double bend = derivative<2>(s.geometry, 0)[i] - derivative<2>(before, before.length)[i];
      ASSERT_LE(std::abs(bend) * s.nominal.v0 * s.nominal.v0, 1e-3 * m.axis[i].a_max) << k << what;
    }
    last = path_state(s, 1e9);
    ASSERT_NEAR(static_cast<double>(last.s), s.geometry.length, 1e-9) << "the profile covers its geometry" << k << what;
    ASSERT_EQ(s.rests, static_cast<double>(last.v) < 1e-6) << k << what;
    if (s.rests) last = {};
    end = point(s.geometry, s.geometry.length);
    const double t_end = static_cast<double>(test::duration_of(s));
    for (int n = 0; n <= 20; ++n) {
      const auto x = path_state(s, t_end * n / 20);
      ASSERT_GE(static_cast<double>(x.v), -1e-9) << "never backwards " << k << what;
      ASSERT_LE(static_cast<double>(x.v), s.v_cap * 1.001) << k << what;
      ASSERT_LE(static_cast<double>(x.s), s.geometry.length + 1e-9) << k << what;
    }
  }
  for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(end[i], bead.end[i], 1e-9) << what;
  ASSERT_TRUE(bead.segments.back().rests) << what;

  // Whole ticks: run-up, bead, run-out.
  const auto ticks = [&](std::size_t from, std::size_t to) {
    long double t = 0;
    for (std::size_t k = from; k < to; ++k) t += test::duration_of(bead.segments[k]);
    return static_cast<double>(t / m.tick_s);
  };
  const std::size_t n = bead.segments.size();
  ASSERT_GE(bead.bead_begin, 1u);
  ASSERT_LT(bead.bead_end, n);
  for (const double t : {ticks(0, bead.bead_begin), ticks(bead.bead_begin, bead.bead_end), ticks(bead.bead_end, n)})
    ASSERT_NEAR(t, std::round(t), 1e-7) << what;

  // The bead starts and ends in its points, and the path leaves their polyline by the tolerance at most.
  const std::vector<AxisVec>& p = spec.points;
  for (std::size_t i = 0; i < m.axes; ++i) {
    ASSERT_NEAR(point(bead.segments[bead.bead_begin].geometry, 0)[i], p.front()[i], 1e-9) << what;
    const Geometry& g = bead.segments[bead.bead_end - 1].geometry;
    ASSERT_NEAR(point(g, g.length)[i], p.back()[i], 1e-9) << what;
  }
  for (std::size_t k = bead.bead_begin; k < bead.bead_end; ++k)
    for (int u = 0; u <= 10; ++u) {
      const Geometry& g = bead.segments[k].geometry;
      ASSERT_LE(test::distance_to_polyline(point(g, g.length * u / 10), p), spec.corner_tolerance_mm + 1e-9) << what;
    }
  const std::vector<AxisVec> path = test::sampled(bead.segments, 2.5e-4);
  for (const AxisVec& corner : p)
    ASSERT_LE(test::distance_to_polyline(corner, path), spec.corner_tolerance_mm + 1e-3)
        << "no corner is cut more" << what;
  const test::Use use = limit_use(m, path, 2.5e-4);
  ASSERT_LE(use.v, 1 + 1e-6) << what;
  ASSERT_LE(use.a, 1 + 1e-5) << what;
  ASSERT_LE(use.j, 1 + 1e-3) << what;
  const auto all = std::span(bead.segments);
  ASSERT_EQ(unsound(m, all, all.subspan(bead.bead_begin, bead.bead_end - bead.bead_begin)).value_or(""), "") << what;
}

TEST(Bead, any_polyline_becomes_a_continuous_motion_within_limits_and_tolerance) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed);
  int planned = 0;
  for (int n = 0; n < 600; ++n) {
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    const double tolerance = uniform(0, 1) < 0.25 ? 0 : std::pow(10.0, uniform(-2.5, 0.3));
    const BeadSpec spec = spec_of(test::random_polyline(random), std::pow(10.0, uniform(0.5, 2.3)), tolerance);
    const auto bead = plan_bead(m, spec);
    const std::string what = " case " + std::to_string(n) + " speed " + std::to_string(spec.speed_mm_s) +
                             " tolerance " + std::to_string(tolerance) + " " + test::text(spec.points);
    if (!bead) {
      ASSERT_NE(bead.error().fault, Fault::SpeedNotReachable) << bead.error().message << what;
      continue;
    }
    ++planned;
    check_bead(m, spec, *bead, what);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(planned, 480);
}

TEST(Bead, holds_its_speed_where_no_corner_limits_it) {
  const Limits m = machine();
  const auto bead = plan_bead(m, spec_of({at(100, 100), at(160, 100), at(160, 140)}, 15, 0.5));
  ASSERT_TRUE(bead);
  for (std::size_t k = bead->bead_begin; k < bead->bead_end; ++k)
    for (int u = 0; u <= 20; ++u) {
      const Segment& s = bead->segments[k];
      EXPECT_NEAR(static_cast<double>(path_state(s, test::duration_of(s) * u / 20).v), 15, 0.01 * 15) << k;
    }
}

TEST(Bead, is_at_its_speed_where_the_valve_opens_and_closes) {
  const Limits m = machine();
  for (const double speed : {5.0, 40.0, 150.0}) {
    const auto bead = plan_bead(m, spec_of({at(100, 100), at(160, 100), at(160, 140)}, speed, 0.5));
    ASSERT_TRUE(bead);
    EXPECT_NEAR(bead->segments[bead->bead_begin].nominal.v0, speed, 0.01 * speed);
    EXPECT_NEAR(bead->segments[bead->bead_end].nominal.v0, speed, 0.01 * speed);
  }
}

/// 0.3 mm at 20 mm/s are 15 ticks, 30 mm are 1500: whatever the board's slope adds to their length.
TEST(Bead, takes_the_same_ticks_on_a_board_that_slopes) {
  const Limits m = machine();
  for (const double length : {0.3, 2.0, 30.0})
    for (const double slope : {0.0, 1e-6, 3.4e-4, 5e-3, 0.02}) {
      if (slope > 3.4e-4 && length > 2) continue;  // there a tick more is no difference in speed
      AxisVec to = at(300 + length, 200);
      to[2] += slope * length;
      const auto bead = plan_bead(m, spec_of({at(300, 200), to}, 20, 0.05));
      ASSERT_TRUE(bead);
      EXPECT_NEAR(bead->bead_seconds, length / 20, 1e-9) << length << " slope " << slope;
    }
  // A thousandth more is more.
  EXPECT_NEAR(plan_bead(m, spec_of({at(300, 200), at(300.301, 200)}, 20, 0.05))->bead_seconds, 0.016, 1e-9);
}

/// At an axis's own speed nothing is left for that: 800 mm/s x 0.25 s is 200 mm.
TEST(Bead, is_never_faster_than_its_axes_may_be) {
  const Limits m = machine();
  const auto bead = plan_bead(m, spec_of({at(250, 200), at(450.004, 200)}, 800, 0.05));
  ASSERT_TRUE(bead) << bead.error().message;
  EXPECT_LE(limit_use(m, test::sampled(bead->segments, 2.5e-4), 2.5e-4).v, 1 + 1e-9);
}

// A circle in chords, at a speed that its curvature allows: no slower than one would drive the circle.
TEST(Bead, a_circle_of_short_chords_keeps_its_speed) {
  std::vector<AxisVec> points;
  for (int k = 0; k <= 377; ++k)
    points.push_back(at(300 + std::round(30e6 * std::cos(2 * M_PI * k / 377)) / 1e6,
                        200 + std::round(30e6 * std::sin(2 * M_PI * k / 377)) / 1e6));
  const Limits m = machine();
  const BeadSpec spec = spec_of(points, 50, 0.05);
  const auto bead = plan_bead(m, spec);
  ASSERT_TRUE(bead);
  check_bead(m, spec, *bead, "circle");
  EXPECT_LE(bead->bead_seconds, 2 * M_PI * 30 / 50 * 1.01);
}

// The machine rounds its way to and from a bead only where lift and turn stand, and asks for no more than equality.
TEST(Bead, an_axis_that_stands_along_it_stands_to_the_last_bit) {
  const Limits m = machine();
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> away(0, 40), turned(-1, 1), radius(2, 9);
  for (int n = 0; n < 6; ++n) {
    std::vector<AxisVec> points;
    const double r = radius(random), lift = away(random), turn = turned(random), z = -away(random);
    for (int k = 0; k <= 16; ++k) {
      const double angle = 2 * std::acos(-1.0) * k / 32;
      points.push_back({250 + r * std::cos(angle), 180 + r * std::sin(angle), z, turn, lift});
    }
    for (const double entry_mm_s : {20.0, 0.0}) {
      BeadSpec spec = spec_of(points, 20, 0.05);
      spec.entry_mm_s = entry_mm_s;
      const auto bead = plan_bead(m, spec);
      ASSERT_TRUE(bead) << bead.error().message;
      for (const std::size_t i : {2UL, 3UL, 4UL}) {
        EXPECT_EQ(bead->start[i], points[0][i]) << n << " axis " << i;
        EXPECT_EQ(bead->end[i], points[0][i]) << n << " axis " << i;
        for (const Segment& piece : bead->segments)
          EXPECT_EQ(point(piece.geometry, piece.geometry.length / 3)[i], points[0][i]) << n << " axis " << i;
      }
    }
  }
}

TEST(Bead, slows_down_for_a_tight_corner_and_not_before_it_must) {
  const Limits m = machine();
  const auto bead = plan_bead(m, spec_of({at(100, 100), at(160, 100), at(160, 140)}, 100, 0.05));
  ASSERT_TRUE(bead);
  double slowest = 1e9, begin = 0, slow_mm = 0;
  for (std::size_t k = bead->bead_begin; k < bead->bead_end; ++k) {
    const Segment& s = bead->segments[k];
    const double t = static_cast<double>(test::duration_of(s));
    for (int n = 0; n < 100; ++n) {
      const auto x = path_state(s, t * n / 100), y = path_state(s, t * (n + 1) / 100);
      slowest = std::min(slowest, static_cast<double>(x.v));
      if (static_cast<double>(x.v) < 95) slow_mm += static_cast<double>(y.s - x.s);
    }
    begin += s.geometry.length;
  }
  EXPECT_LT(slowest, 60);
  EXPECT_GT(slowest, 5);
  // Braking from 100 and speeding up again, at the limits.
  EXPECT_LT(slow_mm, 2.2 * change_length(100, 0, m.axis[1].a_max, m.axis[1].j_max));
}

TEST(Bead, with_no_tolerance_stops_in_its_corners_exactly) {
  const Limits m = machine();
  const auto bead = plan_bead(m, spec_of({at(100, 100), at(160, 100), at(160, 140)}, 20, 0));
  ASSERT_TRUE(bead);
  ASSERT_EQ(bead->segments.size(), 4u);
  EXPECT_TRUE(bead->segments[1].rests);
  EXPECT_EQ(point(bead->segments[2].geometry, 0)[0], 160);
}

TEST(Bead, goes_straight_through_points_that_are_no_corner) {
  const auto bead = plan_bead(machine(), spec_of({at(100, 100), at(120, 110), at(140, 120), at(160, 130)}, 20, 0));
  ASSERT_TRUE(bead);
  EXPECT_EQ(bead->segments.size(), 3u);
  EXPECT_NEAR(bead->bead_seconds, std::hypot(60, 30) / 20, 0.001);
}

TEST(Bead, closed_starts_and_ends_in_one_point_with_straight_run_up_and_run_out) {
  const Limits m = machine();
  const BeadSpec spec = spec_of({at(100, 100), at(160, 100), at(160, 140), at(100, 140), at(100, 100)}, 20, 0.2);
  const auto bead = plan_bead(m, spec);
  ASSERT_TRUE(bead);
  check_bead(m, spec, *bead, "closed");
  EXPECT_LT(bead->start[0], 100);
  EXPECT_EQ(bead->start[1], 100);
  EXPECT_EQ(bead->end[0], 100);
  EXPECT_LT(bead->end[1], 100);
}

TEST(Bead, opens_at_its_first_point_and_closes_at_its_last) {
  const auto bead = plan_bead(machine(), spec_of({at(100, 100), at(160, 100), at(160, 140)}, 20, 0.2));
  ASSERT_TRUE(bead);
  const auto& open = bead->segments[bead->bead_begin].events;
  ASSERT_EQ(open.size(), 1u);
  EXPECT_TRUE(open[0].dispense);
  EXPECT_EQ(open[0].at_s, 0);
  EXPECT_EQ(open[0].value, 1u);
  const Segment& last = bead->segments[bead->bead_end - 1];
  ASSERT_EQ(last.events.size(), 1u);
  EXPECT_EQ(last.events[0].at_s, last.geometry.length);
  EXPECT_EQ(last.events[0].value, 0u);
  BeadSpec dry = spec_of({at(100, 100), at(160, 100)}, 20, 0.2);
  dry.valve = 0;
  const auto silent = plan_bead(machine(), dry);
  for (const Segment& s : silent->segments) EXPECT_TRUE(s.events.empty());
}

TEST(Bead, says_what_is_wrong_with_it) {
  const Limits m = machine();
  EXPECT_EQ(plan_bead(m, spec_of({at(1, 1)}, 20, 0)).error().fault, Fault::NoSolution);
  EXPECT_EQ(plan_bead(m, spec_of({at(1, 1), at(1, 1)}, 20, 0)).error().fault, Fault::NoSolution);
  EXPECT_EQ(plan_bead(m, spec_of({at(1, 1), at(2, 1)}, 0, 0)).error().fault, Fault::NoSolution);
  EXPECT_EQ(plan_bead(m, spec_of({at(1, 1), at(900, 1)}, 20, 0)).error().fault, Fault::OutOfReach);
  AxisVec turned = at(1, 1);
  turned[3] = 1;
  EXPECT_EQ(plan_bead(m, spec_of({at(1, 1), turned}, 20, 0)).error().fault, Fault::NoSolution);
  Limits named = m;
  named.name[0] = {'X'};
  const auto edge = plan_bead(named, spec_of({at(-9.99, 100), at(50, 100)}, 200, 0));
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().fault, Fault::SpeedNotReachable);
  EXPECT_NE(edge.error().message.find("run-up"), std::string::npos);
  EXPECT_NE(edge.error().message.find("soft limits of axis X;"), std::string::npos) << edge.error().message;
}

/// Ticks of the segments [from, to).
double ticks_of(const Limits& m, const BeadMotion& bead, std::size_t from, std::size_t to) {
  long double t = 0;
  for (std::size_t k = from; k < to; ++k) t += test::duration_of(bead.segments[k]);
  return static_cast<double>(t / m.tick_s);
}

/// What every beginning has to be: no jump, within the limits, in whole ticks, and the bead goes through its points.
void check_beginning(const Limits& m, const BeadSpec& spec, const BeadMotion& bead, const std::string& what) {
  AxisVec end = bead.start;
  for (const Segment& s : bead.segments) {
    for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(point(s.geometry, 0)[i], end[i], 1e-9) << what;
    if (s.kind == SegmentKind::Piece) {
      ASSERT_NEAR(static_cast<double>(path_state(s, 1e9).s), s.geometry.length, 1e-9) << what;
      end = point(s.geometry, s.geometry.length);
    }
  }
  for (const double t : {ticks_of(m, bead, 0, bead.bead_begin), ticks_of(m, bead, bead.bead_begin, bead.bead_end)})
    ASSERT_NEAR(t, std::round(t), 1e-7) << what;
  const std::vector<AxisVec> path = test::sampled(bead.segments, 2.5e-4);
  const test::Use use = limit_use(m, path, 2.5e-4);
  ASSERT_LE(use.v, 1 + 1e-6) << what;
  ASSERT_LE(use.a, 1 + 1e-5) << what;
  ASSERT_LE(use.j, 1 + 1e-3) << what;
  for (std::size_t i = 0; i < m.axes; ++i)
    ASSERT_NEAR(point(bead.segments[bead.bead_begin].geometry, 0)[i], spec.points.front()[i], 1e-9) << what;
  for (const AxisVec& corner : spec.points)
    ASSERT_LE(test::distance_to_polyline(corner, path), spec.corner_tolerance_mm + 1e-3) << what;
}

TEST(Bead, that_is_to_begin_slowly_or_from_rest_or_from_above_keeps_limits_and_points) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed + 1);
  int slow = 0, rest = 0, above = 0;
  for (int n = 0; n < 100; ++n) {
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    const double tolerance = uniform(0, 1) < 0.25 ? 0 : std::pow(10.0, uniform(-2.5, 0.3));
    BeadSpec spec = spec_of(test::random_polyline(random), std::pow(10.0, uniform(0.5, 2.3)), tolerance);
    const auto whole = plan_bead(m, spec);
    if (!whole) continue;
    const std::string what = " case " + std::to_string(n) + " " + test::text(spec.points);

    BeadSpec slower = spec;
    slower.entry_mm_s = uniform(0.05, 1) * spec.speed_mm_s;
    if (const auto bead = plan_bead(m, slower)) {
      ++slow;
      check_beginning(m, slower, *bead, " slower" + what);
      EXPECT_LE(bead->run_up_mm, whole->run_up_mm * 1.01 + 1e-3) << what;
      const Segment& first = bead->segments[bead->bead_begin];
      const Bounds b = line_bounds(m, derivative<1>(first.geometry, 0));
      EXPECT_LE(bead->run_up_mm, 1.06 * change_length(0, slower.entry_mm_s, 0.97 * b.a, 0.98 * b.j) + 1e-9) << what;
    }
    BeadSpec still = spec;
    still.entry_mm_s = 0;
    still.stand_s = 0.137;
    if (const auto bead = plan_bead(m, still)) {
      ++rest;
      check_beginning(m, still, *bead, " rest" + what);
      EXPECT_EQ(bead->bead_begin, 0u);
      EXPECT_EQ(bead->run_up_mm, 0);
      const Segment& stands = bead->segments[0];
      EXPECT_EQ(stands.kind, SegmentKind::Dwell);
      EXPECT_NEAR(static_cast<double>(test::duration_of(stands)), 0.137, 1e-9);
      ASSERT_EQ(stands.events.size(), 1u);
      EXPECT_TRUE(stands.events[0].dispense);
      EXPECT_EQ(stands.events[0].at_s, 0);
      EXPECT_EQ(bead->segments[1].nominal.v0, 0);
    }
    BeadSpec fallen = spec;
    fallen.lift_axis = 2;
    fallen.fall_mm = uniform(0.5, 10);
    if (const auto bead = plan_bead(m, fallen)) {
      ++above;
      check_beginning(m, fallen, *bead, " above" + what);
      EXPECT_NEAR(bead->start[2] - whole->start[2], fallen.fall_mm, 1e-9) << what;
      EXPECT_NEAR(bead->start[0], whole->start[0], 1e-9) << what;
      EXPECT_NEAR(bead->run_up_mm, whole->run_up_mm, 1e-9) << what;
      EXPECT_GE(ticks_of(m, *bead, 0, bead->bead_begin), ticks_of(m, *whole, 0, whole->bead_begin) - 1e-6) << what;
    }
    if (HasFatalFailure() || HasNonfatalFailure()) return;
  }
  EXPECT_GT(slow, 60);
  EXPECT_GT(rest, 60);
  EXPECT_GT(above, 60);
}

/// Chords of an arc from angle 0 on, left turning.
std::vector<AxisVec> arc_points(double r, double turn, double chord) {
  std::vector<AxisVec> out;
  const int chords = static_cast<int>(std::ceil(r * turn / chord));
  for (int k = 0; k <= chords; ++k)
    out.push_back(at(300 + r * std::cos(turn * k / chords), 250 + r * std::sin(turn * k / chords)));
  return out;
}

// A run-up that is straight leaves the change of curvature to the bead.
TEST(Bead, that_begins_and_ends_on_a_curve_holds_its_speed_from_its_first_point_to_its_last) {
  const Limits m = machine();
  const AxisLimits& y = m.axis[1];
  for (const double r : {1.0, 3.0, 8.0, 40.0})
    for (const double turn : {1.5, 3.0, 6.283})
      for (const double share : {0.5, 0.9}) {
        const double v = share * std::min({0.99 * y.v_max, std::sqrt(y.a_max * r), std::cbrt(y.j_max * r * r)});
        const BeadSpec spec = spec_of(arc_points(r, turn, 0.1 * std::sqrt(r)), v, 0.05);
        const std::string what =
            " r " + std::to_string(r) + " turn " + std::to_string(turn) + " v " + std::to_string(v);
        const auto bead = plan_bead(m, spec);
        ASSERT_TRUE(bead) << bead.error().message << what;
        check_bead(m, spec, *bead, what);
        if (HasFatalFailure()) return;
        // A short one is slower because it takes whole ticks.
        const double ticks = r * turn / v / m.tick_s, least = 0.99 * v * ticks / (ticks + 1);
        for (std::size_t k = bead->bead_begin; k < bead->bead_end; ++k)
          for (int n = 0; n <= 20; ++n) {
            const Segment& s = bead->segments[k];
            const auto x = path_state(s, static_cast<double>(test::duration_of(s)) * n / 20);
            ASSERT_GE(static_cast<double>(x.v), least) << k << what;
          }

        BeadSpec slower = spec;
        slower.entry_mm_s = v / 3;
        const auto slow = plan_bead(m, slower);
        ASSERT_TRUE(slow) << slow.error().message << what;
        check_beginning(m, slower, *slow, " slower" + what);
        EXPECT_LT(slow->run_up_mm, 0.5 * bead->run_up_mm) << what;

        BeadSpec fallen = spec;
        fallen.lift_axis = 2, fallen.fall_mm = 4;
        const auto above = plan_bead(m, fallen);
        ASSERT_TRUE(above) << above.error().message << what;
        check_beginning(m, fallen, *above, " above" + what);
        EXPECT_NEAR(above->start[2], -46, 1e-9) << what;
        EXPECT_GE(above->segments[above->bead_begin].nominal.v0, least) << what;
        if (HasFatalFailure() || HasNonfatalFailure()) return;
      }
}

// On a board that slopes, everything of a bead lies in the board's plane, what leads to it and away from it too: what
// it is bent by is out of the plane no more than rounding.
TEST(Bead, on_a_board_that_slopes_stays_in_its_plane_from_rest_to_rest) {
  const Limits m = machine();
  const AxisLimits& y = m.axis[1];
  for (const double r : {1.07, 1.81, 2.56, 8.0, 40.0})
    for (const double turn : {1.047, 3.0, 6.283})
      for (const double tolerance : {0.05, 0.2, 0.4})
        for (const auto& [tilt_x, tilt_y] : {std::pair{0.0009, 0.0009}, {0.0017, -0.0017}, {0.02, 0.013}})
          for (const double share : {0.5, 1.0}) {
            const double v = share * std::min({0.99 * y.v_max, std::sqrt(y.a_max * r), std::cbrt(y.j_max * r * r)});
            const auto height = [&](const AxisVec& q) { return -50 + tilt_x * (q[0] - 300) + tilt_y * (q[1] - 250); };
            BeadSpec spec = spec_of(arc_points(r, turn, std::min(1.0, 0.1 * std::sqrt(r))), v, tolerance);
            for (AxisVec& q : spec.points) q[2] = height(q);
            const std::string what = " r " + std::to_string(r) + " turn " + std::to_string(turn) + " tolerance " +
                                     std::to_string(tolerance) + " tilt " + std::to_string(tilt_x) + " v " +
                                     std::to_string(v);
            const auto bead = plan_bead(m, spec);
            ASSERT_TRUE(bead) << bead.error().message << what;
            check_bead(m, spec, *bead, what);
            if (HasFatalFailure()) return;
            for (const Segment& s : bead->segments)
              for (int u = 0; u <= 10; ++u) {
                const AxisVec q = point(s.geometry, s.geometry.length * u / 10);
                EXPECT_NEAR(q[2], height(q), 1e-6) << what;
              }
            if (HasNonfatalFailure()) return;
          }
}

// The inside of a tolerance that is a large part of the radius is the narrower way.
TEST(Bead, on_a_curve_is_no_slower_for_a_larger_tolerance) {
  const Limits m = machine();
  const AxisLimits& y = m.axis[1];
  for (const double r : {1.0, 1.5, 2.5})
    for (const double turn : {3.2, 6.283})
      for (const double tolerance : {0.02, 0.1, 0.2, 0.4}) {
        const double v = 0.95 * std::min({0.99 * y.v_max, std::sqrt(y.a_max * r), std::cbrt(y.j_max * r * r)});
        const BeadSpec spec = spec_of(arc_points(r, turn, 0.1), v, tolerance);
        const auto bead = plan_bead(m, spec);
        const std::string what = " r " + std::to_string(r) + " turn " + std::to_string(turn) + " tolerance " +
                                 std::to_string(tolerance) + " v " + std::to_string(v);
        ASSERT_TRUE(bead) << bead.error().message << what;
        check_bead(m, spec, *bead, what);
        EXPECT_GE(bead->bead_length_mm / bead->bead_seconds, 0.97 * v) << what;
        if (HasFatalFailure() || HasNonfatalFailure()) return;
      }
}

// Cut and joined again it goes on along the path on which it was begun, however it was: from rest, slowly or at speed.
TEST(Bead, is_laid_on_one_path_however_it_begins) {
  const Limits m = machine();
  for (const auto& [r, tolerance, v] :
       {std::tuple{5.0, 0.4, 40.0}, {8.0, 0.2, 60.0}, {3.0, 0.05, 20.0}, {2.0, 1.0, 10.0}})
    for (const double turn : {0.3, 1.0, 6.283}) {
      const BeadSpec at_speed = spec_of(arc_points(r, turn, 0.1), v, tolerance);
      const std::string what = " r " + std::to_string(r) + " turn " + std::to_string(turn);
      const auto whole = plan_bead(m, at_speed);
      ASSERT_TRUE(whole) << whole.error().message << what;
      for (const double entry : {0.0, v / 5}) {
        BeadSpec slow = at_speed;
        slow.entry_mm_s = entry;
        const auto begun = plan_bead(m, slow);
        ASSERT_TRUE(begun) << begun.error().message << what;
        EXPECT_NEAR(begun->bead_length_mm, whole->bead_length_mm, 1e-6) << what << " entry " << entry;
        BeadSpec rest = slow;
        rest.begin_mm = 0.6 * whole->bead_length_mm;
        const auto joined = plan_bead(m, rest);
        ASSERT_TRUE(joined) << joined.error().message << what;
        EXPECT_NEAR(joined->bead_length_mm, 0.4 * whole->bead_length_mm, 1e-6) << what << " entry " << entry;
      }
    }
}

TEST(Bead, from_rest_on_a_line_is_the_textbooks_change_of_speed) {
  const Limits m = machine();
  BeadSpec spec = spec_of({at(100, 100), at(160, 100)}, 20, 0);
  spec.entry_mm_s = 0;
  const auto bead = plan_bead(m, spec);
  ASSERT_TRUE(bead);
  // From rest to 20 mm/s at the jerk that beads use, 0.98 of 80,000 mm/s3, takes 2 sqrt(v/j), half of it at the mean
  // speed: the bead is that much later than one that is at its speed from the start.
  const double late_s = std::sqrt(20 / (0.98 * 80000));
  EXPECT_NEAR(ticks_of(m, *bead, 0, bead->bead_end) * m.tick_s, 60.0 / 20 + late_s, 1.001 * m.tick_s);
  EXPECT_EQ(bead->start, spec.points.front());
  ASSERT_FALSE(bead->segments[0].events.empty());
  EXPECT_TRUE(bead->segments[0].events[0].dispense) << "the valve opens where it begins";
  EXPECT_EQ(bead->segments[0].events[0].at_s, 0);
}

/// An arc that begins near a limit and leaves it, at all angles: its run-up may bend out over it and back. Seen tick by
/// tick as the loop does, on all four sides.
TEST(Bead, that_begins_near_the_edge_of_the_travel_stays_within_it_or_is_refused) {
  Limits m = machine();
  for (const std::size_t i : {0u, 1u, 2u}) m.axis[i] = {0, 300, 200, 3000, 50000};
  int planned = 0, refused = 0;
  for (const double radius : {5.0, 10.0})
    for (const double speed : {50.0, 100.0, 150.0})
      for (const double degrees : {1.0, 5.0, 15.0, 30.0, 60.0, 90.0})
        for (const double off_mm : {0.0, 0.3, 1.0, 3.0, 10.0})
          for (const int side : {0, 1, 2, 3})
            for (const bool ends : {false, true}) {
              std::vector<AxisVec> points;
              const double leaves = degrees * std::numbers::pi / 180;
              for (int k = 0; k <= 60; ++k) {
                const double turn = leaves + 1.0 * k / 60;
                const double along = radius * (std::sin(turn) - std::sin(leaves)),
                             in = off_mm + radius * (std::cos(leaves) - std::cos(turn));
                const double x = 150 + (side % 2 == 0 ? along : -along), y = side < 2 ? in : 300 - in;
                points.push_back(side % 2 == 0 ? at(x, y) : at(y, x));
                points.back()[2] = 10;
              }
              if (ends) std::reverse(points.begin(), points.end());
              const auto bead = plan_bead(m, spec_of(points, speed, 0.05));
              if (!bead) {
                EXPECT_NE(bead.error().message.find("soft limits"), std::string::npos) << bead.error().message;
                ++refused;
                continue;
              }
              ++planned;
              double t = 0;
              for (const Segment& s : bead->segments) {
                for (const double lasts = duration(s.nominal); t < lasts; t += m.tick_s) {
                  const AxisVec q = point(s.geometry, along(s.nominal, t).x.p);
                  for (const std::size_t i : {0u, 1u})
                    ASSERT_TRUE(q[i] > -1e-8 && q[i] < 300 + 1e-8) << q[i] << ": radius " << radius << ", " << speed
                                                                   << " mm/s, " << degrees << " deg, side " << side;
                }
                t -= duration(s.nominal);
              }
            }
  EXPECT_GT(planned, 50);
  EXPECT_GT(refused, 50);
}

}  // namespace
}  // namespace gantry::motion
