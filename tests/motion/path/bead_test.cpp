#include "motion/path/bead.hpp"

#include <gtest/gtest.h>

#include "motion/path/blend.hpp"
#include "motion/path/moves.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion {
namespace {

using test::limit_use;
using test::machine;
using test::path_state;

constexpr unsigned kSeed = 11;

BeadSpec spec_of(std::vector<AxisVec> points, double speed, double tolerance) {
  BeadSpec s;
  s.points = std::move(points);
  s.speed_mm_s = speed;
  s.corner_tolerance_mm = tolerance;
  s.valve = 1;
  s.open_lead_s = 0.012;
  s.close_lead_s = 0.007;
  return s;
}

AxisVec at(double x, double y) { return {x, y, -50, 0, 12}; }

/// Everything that any bead has to be.
void check_bead(const Limits& m, const BeadSpec& spec, const BeadMotion& bead, const std::string& what) {
  // Boundaries: position, speed and acceleration go on.
  AxisVec end = bead.start;
  test::PathState last;
  for (std::size_t k = 0; k < bead.segments.size(); ++k) {
    const Segment& s = bead.segments[k];
    ASSERT_NEAR(s.nominal.v0, static_cast<double>(last.v), 1e-9 * spec.speed_mm_s) << k << what;
    ASSERT_NEAR(s.nominal.a0, static_cast<double>(last.a), 1e-6) << k << what;
    for (std::size_t i = 0; i < m.axes; ++i) {
      ASSERT_NEAR(point(s.geometry, 0)[i], end[i], 1e-10) << k << what;
      if (k == 0) continue;
      const Geometry& before = bead.segments[k - 1].geometry;
      if (s.nominal.v0 == 0) continue;  // a corner with a stop has no common tangent
      ASSERT_NEAR(derivative<1>(s.geometry, 0)[i], derivative<1>(before, before.length)[i], 2e-9) << k << what;
      ASSERT_NEAR(derivative<2>(s.geometry, 0)[i], derivative<2>(before, before.length)[i], 1e-7) << k << what;
    }
    last = path_state(s, 1e9);
    ASSERT_NEAR(static_cast<double>(last.s), s.geometry.length, 1e-9) << "the profile covers its geometry" << k << what;
    ASSERT_NEAR(s.v_exit, static_cast<double>(last.v), 1e-9) << k << what;
    end = point(s.geometry, s.geometry.length);
    const double t_end = static_cast<double>(test::duration_of(s));
    for (int n = 0; n <= 50; ++n) {
      const auto x = path_state(s, t_end * n / 50);
      ASSERT_GE(static_cast<double>(x.v), -1e-9) << "never backwards " << k << what;
      ASSERT_LE(static_cast<double>(x.v), s.v_max * (1 + 1e-9)) << k << what;
      ASSERT_LE(static_cast<double>(x.v), s.v_cap * (1 + 1e-9)) << k << what;
      ASSERT_LE(std::abs(static_cast<double>(x.a)), s.a_max * (1 + 1e-9)) << k << what;
    }
    for (const Phase& phase : s.nominal.phases) ASSERT_LE(std::abs(phase.jerk), s.j_max * (1 + 1e-9)) << k << what;
  }
  for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(end[i], bead.end[i], 1e-9) << what;
  ASSERT_NEAR(static_cast<double>(last.v), 0, 1e-9) << what;

  // Whole ticks: run-up, bead, run-out.
  const auto ticks = [&](std::size_t from, std::size_t to) {
    long double t = 0;
    for (std::size_t k = from; k < to; ++k) t += test::duration_of(bead.segments[k]);
    return static_cast<double>(t / m.tick_s);
  };
  const std::size_t n = bead.segments.size();
  for (const double t : {ticks(0, 1), ticks(1, n - 1), ticks(n - 1, n)}) ASSERT_NEAR(t, std::round(t), 1e-8) << what;

  // The bead starts and ends in its points, on speed, and the corners are cut by the tolerance at most.
  const std::vector<AxisVec>& p = spec.points;
  for (std::size_t i = 0; i < m.axes; ++i) {
    ASSERT_NEAR(point(bead.segments[1].geometry, 0)[i], p.front()[i], 1e-9) << what;
    const Geometry& g = bead.segments[n - 2].geometry;
    ASSERT_NEAR(point(g, g.length)[i], p.back()[i], 1e-9) << what;
  }
  for (std::size_t k = 1; k + 1 < n; ++k)
    for (int u = 0; u <= 40; ++u) {
      const Geometry& g = bead.segments[k].geometry;
      ASSERT_LE(test::distance_to_polyline(point(g, g.length * u / 40), p), spec.corner_tolerance_mm + 1e-9) << what;
    }
  const test::Use use = limit_use(m, test::sampled(bead.segments, 2.5e-4), 2.5e-4);
  ASSERT_LE(use.v, 1 + 1e-6) << what;
  ASSERT_LE(use.a, 1 + 1e-6) << what;
  ASSERT_LE(use.j, 1 + 1e-4) << what;
}

TEST(Bead, any_polyline_becomes_a_continuous_motion_within_limits_and_tolerance) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed);
  int planned = 0;
  for (int n = 0; n < 1000; ++n) {
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
  EXPECT_GT(planned, 800);
}

TEST(Bead, holds_its_speed_where_no_corner_limits_it) {
  const Limits m = machine();
  const auto bead = plan_bead(m, spec_of({at(100, 100), at(160, 100), at(160, 140)}, 15, 0.5));
  ASSERT_TRUE(bead);
  const double cap = bead->segments[1].v_cap;
  EXPECT_GE(cap, 15 * (1 - 0.001 / bead->bead_seconds));
  for (std::size_t k = 1; k + 1 < bead->segments.size(); ++k)
    for (int u = 0; u <= 20; ++u) {
      const Segment& s = bead->segments[k];
      EXPECT_NEAR(static_cast<double>(path_state(s, test::duration_of(s) * u / 20).v), cap, 1e-6) << k;
    }
}

TEST(Bead, slows_down_for_a_tight_corner_and_not_before_it_must) {
  const Limits m = machine();
  const auto bead = plan_bead(m, spec_of({at(100, 100), at(160, 100), at(160, 140)}, 100, 0.05));
  ASSERT_TRUE(bead);
  ASSERT_EQ(bead->segments.size(), 5u);
  const double corner = bead->segments[1].v_exit;
  EXPECT_LT(corner, 30);
  EXPECT_GT(corner, 5);
  const Segment& s = bead->segments[1];
  EXPECT_GT(static_cast<double>(path_state(s, test::duration_of(s) * 0.8).v), 90);
}

TEST(Bead, with_no_tolerance_stops_in_its_corners_exactly) {
  const Limits m = machine();
  const auto bead = plan_bead(m, spec_of({at(100, 100), at(160, 100), at(160, 140)}, 20, 0));
  ASSERT_TRUE(bead);
  ASSERT_EQ(bead->segments.size(), 4u);
  EXPECT_NEAR(bead->segments[1].v_exit, 0, 1e-12);
  EXPECT_EQ(point(bead->segments[2].geometry, 0)[0], 160);
}

TEST(Bead, goes_straight_through_points_that_are_no_corner) {
  const auto bead = plan_bead(machine(), spec_of({at(100, 100), at(120, 110), at(140, 120), at(160, 130)}, 20, 0));
  ASSERT_TRUE(bead);
  for (std::size_t k = 0; k + 2 < bead->segments.size(); ++k) EXPECT_GT(bead->segments[k].v_exit, 19);
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
  const auto& open = bead->segments[1].events;
  ASSERT_EQ(open.size(), 1u);
  EXPECT_TRUE(open[0].dispense);
  EXPECT_EQ(open[0].at_s, 0);
  EXPECT_EQ(open[0].value, 1u);
  const Segment& last = bead->segments[bead->segments.size() - 2];
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
  const auto edge = plan_bead(m, spec_of({at(-9.99, 100), at(50, 100)}, 200, 0));
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().fault, Fault::SpeedNotReachable);
  EXPECT_NE(edge.error().message.find("run-up"), std::string::npos);
}

// The closed form against dense sampling: the nearest that the curve comes to the corner.
TEST(Blend, leaves_its_corner_by_exactly_the_tolerance) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed);
  for (int n = 0; n < 2000; ++n) {
    std::uniform_real_distribution<double> angle(-3.1, 3.1), slope(-0.3, 0.3);
    const auto direction = [&] {
      const double a = angle(random), z = slope(random), k = 1 / std::sqrt(1 + z * z);
      return AxisVec{k * std::cos(a), k * std::sin(a), k * z, slope(random)};
    };
    const AxisVec d1 = direction(), d2 = direction(), corner{50, 60, -20, 1};
    const double tolerance = 0.1, d = blend_reach(m, d1, d2, tolerance);
    const Geometry g = blend(corner, d1, d2, d);
    double nearest = 1e9;
    for (int u = 0; u <= 2000; ++u) {
      const AxisVec q = point(g, g.length * u / 2000);
      nearest = std::min(nearest, std::hypot(q[0] - corner[0], q[1] - corner[1], q[2] - corner[2]));
    }
    ASSERT_NEAR(nearest, tolerance, 1e-9) << n;
  }
}

TEST(Blend, bounds_keep_every_axis_within_its_limits_in_any_combination) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> angle(0, 6.3), any(-0.5, 0.5), sign(-1, 1);
  double highest = 0;
  for (int n = 0; n < 20000; ++n) {
    const double a1 = angle(random), a2 = angle(random);
    const AxisVec d1{std::cos(a1), std::sin(a1), 0, any(random)}, d2{std::cos(a2), std::sin(a2), 0, any(random)};
    const double d = std::pow(10.0, std::uniform_real_distribution<double>(-3, 1)(random));
    const Geometry g = blend(AxisVec{}, d1, d2, d);
    const Bounds b = blend_bounds(m, d1, d2, d, std::pow(10.0, std::uniform_real_distribution<double>(0, 3)(random)));
    ASSERT_GT(b.v, 0);
    ASSERT_GT(b.a, 0);
    ASSERT_GT(b.j, 0);
    for (int u = 0; u <= 20; ++u) {
      const double s = g.length * u / 20, v = b.v, a = std::copysign(b.a, sign(random)),
                   j = std::copysign(b.j, sign(random));
      const AxisVec q1 = derivative<1>(g, s), q2 = derivative<2>(g, s), q3 = derivative<3>(g, s);
      for (std::size_t i = 0; i < m.axes; ++i) {
        ASSERT_LE(std::abs(q1[i] * v), m.axis[i].v_max * (1 + 1e-9));
        ASSERT_LE(std::abs(q2[i] * v * v + q1[i] * a), m.axis[i].a_max * (1 + 1e-9));
        const double jerk = std::abs(q3[i] * v * v * v + 3 * q2[i] * v * a + q1[i] * j);
        ASSERT_LE(jerk, m.axis[i].j_max * (1 + 1e-9));
        highest = std::max(highest, jerk / m.axis[i].j_max);
      }
    }
  }
  EXPECT_GT(highest, 0.9);
}

}  // namespace
}  // namespace gantry::motion
