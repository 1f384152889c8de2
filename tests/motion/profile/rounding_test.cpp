// Where rounding lies on the edge between no motion and a detour of seconds: targets that are the start, or lie on its
// last ramp, but for rounding; starts a hair outside of the bounds.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "motion/profile/planner.hpp"
#include "motion/profile/together.hpp"
#include "tests/motion/profile/judge.hpp"

namespace gantry::motion {
namespace {

class Draw {
 public:
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
  double normal(double sigma) { return std::normal_distribution<double>(0, sigma)(random_); }
  AxisBounds bounds() { return {uniform(0.08, 16), uniform(0.08, 16), uniform(0.08, 16)}; }
  /// Within the bounds, and so is the speed that it leads to and the one that it comes from.
  State state(const AxisBounds& b) {
    for (;;) {
      const State x{normal(4), normal(0.8), normal(0.8)};
      if (std::abs(x.a) <= b.a_max && judge::tenable(x, b, 1) && judge::tenable(x, b, -1)) return x;
    }
  }
  State off_by_rounding(State x) {
    for (double* value : {&x.p, &x.v, &x.a}) *value = std::nextafter(*value, uniform(-1, 1) > 0 ? 1e9 : -1e9);
    return x;
  }

 private:
  std::mt19937_64 random_{20261121};
};

TEST(Rounding, axes_whose_targets_are_their_states_take_no_time) {
  Draw draw;
  for (int n = 0; n < 20000; ++n) {
    AxisMove axes[3];
    for (AxisMove& m : axes) {
      m.bounds = draw.bounds();
      m.from = draw.state(m.bounds), m.to = draw.off_by_rounding(m.from);
      if (n % 2) m.bounds.p_min = m.from.p - 1, m.bounds.p_max = m.from.p + 1;
    }
    const Joint joint = move_together(axes);
    ASSERT_TRUE(joint) << "case " << n << " " << name(joint.reason);
    ASSERT_LT(joint.duration_s, 1e-6) << "case " << n;
  }
}

TEST(Rounding, a_speed_that_one_ramp_comes_to_takes_that_ramp) {
  Draw draw;
  for (int n = 0; n < 50000; ++n) {
    const AxisBounds b = draw.bounds();
    const double a0 = draw.uniform(-b.a_max, b.a_max), a1 = n % 4 ? draw.uniform(-b.a_max, b.a_max) : a0;
    const double t = std::abs(a1 - a0) / b.j_max, v0 = draw.normal(0.8);
    const Plan plan = change_speed({0, v0, a0}, v0 + t * (a0 + a1) / 2, b, a1);
    ASSERT_TRUE(plan);
    ASSERT_LE(duration(plan.profile), t * (1 + 1e-9) + 1e-12) << "case " << n << ": a " << a0 << " to " << a1;
  }
}

TEST(Rounding, whoever_plans_anew_on_the_last_ramp_keeps_to_it) {
  Draw draw;
  int ramps = 0;
  for (int n = 0; n < 20000; ++n) {
    const AxisBounds b = draw.bounds();
    const State from = draw.state(b), to = draw.state(b);
    const Plan plan = move(from, to, b);
    ASSERT_TRUE(plan);
    if (plan.profile.phases.empty()) continue;
    const double all = duration(plan.profile), last = plan.profile.phases.back().duration_s;
    const double left = last * draw.uniform(0.01, 0.99);
    const State here = evaluate(plan.profile, all - left);
    const Plan again = move(here, to, b);
    ASSERT_TRUE(again) << "case " << n << " " << name(again.reason);
    ASSERT_LE(duration(again.profile), left + 1e-6 * all) << "case " << n;
    ASSERT_EQ(judge::verdict(again.profile, here, to, b), "") << "case " << n;
    ++ramps;
  }
  EXPECT_GT(ramps, 19000);
}

TEST(Rounding, a_start_a_hair_over_a_bound_is_planned_between_position_limits_as_without) {
  Draw draw;
  for (int n = 0; n < 5000; ++n) {
    AxisBounds b = draw.bounds();
    const double over = std::pow(10, draw.uniform(-15, -9));
    const State from{draw.normal(4), b.v_max * (1 + over), 0}, to{from.p + 10 + std::abs(draw.normal(4)), 0, 0};
    const Plan open = move(from, to, b);
    b.p_min = from.p - 1e5, b.p_max = to.p + 1e5;
    const Plan between = move(from, to, b);
    ASSERT_TRUE(open && between) << "case " << n << ", over by " << over << ": " << name(between.reason);
    ASSERT_NEAR(duration(between.profile), duration(open.profile), 1e-9 * duration(open.profile)) << "case " << n;
  }
}

TEST(Rounding, what_is_far_smaller_than_the_bounds_is_moved_all_the_same) {
  for (const double travel : {1e-6, 1e-3, 1.0})
    for (const double v_max : {1.0, 1e4, 1e6}) {
      const AxisBounds b(v_max, 1, 10);
      const Plan plan = move({0, 0, 0}, {travel, 0, 0}, b);
      ASSERT_TRUE(plan) << travel << " at " << v_max;
      EXPECT_NEAR(end_state(plan.profile).p, travel, 1e-9 * travel) << "v_max " << v_max;
    }
}

TEST(Outside, one_that_brakes_too_hard_leaves_the_other_bound_no_farther_than_it_must) {
  const AxisBounds b(1, 8, 10);
  const State from{0, 2, -6.5};
  const Plan plan = move(from, {1, 0, 0}, b, Outside::Soonest);
  ASSERT_TRUE(plan) << name(plan.reason);
  const double unavoidable = from.v - from.a * from.a / (2 * b.j_max);  // full jerk from the start on
  double lowest = 0;
  for (double t = 0; t < duration(plan.profile); t += 1e-4) lowest = std::min(lowest, evaluate(plan.profile, t).v);
  EXPECT_LT(unavoidable, -0.1);
  EXPECT_GE(lowest, std::min(unavoidable, b.v_min) - 1e-3);
}

TEST(Outside, easing_passes_the_bound_where_the_start_brakes_through_it) {
  const AxisBounds b(1, 3, 20);
  const Plan exact = move({0, 1, -2.5}, {0.5, 0, 0}, b), over = move({0, 1 + 1e-10, -2.5}, {0.5, 0, 0}, b);
  ASSERT_TRUE(exact && over);
  EXPECT_NEAR(duration(over.profile), duration(exact.profile), 1e-6);
}

}  // namespace
}  // namespace gantry::motion
