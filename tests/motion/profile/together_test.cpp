// Several axes together, judged by the integrator of judge.hpp and by what the durations must be.
#include "motion/profile/together.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/motion/profile/judge.hpp"

namespace gantry::motion {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  AxisMove axis(bool one_sided) {
    for (;;) {
      AxisMove m;
      m.bounds = AxisBounds(bound(), bound(), bound());
      if (one_sided) m.bounds.v_min = -bound(), m.bounds.a_min = -bound(), m.bounds.j_min = -bound();
      m.from = {4 * normal_(random_), some(), some()};
      m.to = {4 * normal_(random_), some(), some()};
      if (judge::tenable(m.from, m.bounds, 1) && judge::tenable(m.to, m.bounds, -1)) return m;
    }
  }
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }

 private:
  double bound() { return uniform(0.08, 16); }
  double some() { return uniform(0, 1) < 0.25 ? 0.0 : 0.8 * normal_(random_); }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

void expect_arrival(const Joint& joint, std::span<const AxisMove> axes, double duration_s) {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    ASSERT_EQ(judge::verdict(joint.profiles[i], axes[i].from, axes[i].to, axes[i].bounds), "") << "axis " << i;
    ASSERT_NEAR(duration(joint.profiles[i]), duration_s, 1e-12 * (1 + duration_s)) << "axis " << i;
  }
}

TEST(Together, all_axes_arrive_at_once_and_none_could_be_waited_for_less) {
  for (const bool one_sided : {false, true}) {
    Draw draw(1 + one_sided);
    int waited = 0;
    for (int n = 0; n < 60000; ++n) {
      const AxisMove axes[] = {draw.axis(one_sided), draw.axis(one_sided), draw.axis(one_sided)};
      const Joint joint = move_together(axes);
      ASSERT_TRUE(joint) << name(joint.reason) << " case " << n;
      expect_arrival(joint, axes, joint.duration_s);
      double slowest = 0;
      for (const AxisMove& m : axes) slowest = std::max(slowest, duration(move(m.from, m.to, m.bounds).profile));
      ASSERT_GE(joint.duration_s, slowest * (1 - 1e-12)) << "case " << n;
      if (joint.duration_s <= slowest * (1 + 1e-9)) continue;
      // Longer than the slowest alone: just before, some axis must have been unable to take so long, however it moves.
      ++waited;
      for (const double share : {0.999999, 0.99}) {
        const double t = slowest + (joint.duration_s - slowest) * share;
        bool blocked = false;
        for (const AxisMove& m : axes) {
          const Joint alone = move_together(std::span(&m, 1), {.min_duration_s = t});
          blocked |= !alone || alone.duration_s > (t + joint.duration_s) / 2;
        }
        ASSERT_TRUE(blocked) << "case " << n;
      }
    }
    EXPECT_GT(waited, 100) << "blocked durations should occur";
  }
}

// A motion that was drawn at random is a witness that its duration is not blocked.
TEST(Together, no_duration_that_a_random_motion_takes_is_called_blocked) {
  Draw draw(3);
  for (int n = 0; n < 200000; ++n) {
    AxisMove m = draw.axis(n % 2);
    Profile witness{m.from, {}};
    double sign = draw.uniform(0, 1) < 0.5 ? 1 : -1;
    for (int k = 0; k < 5; ++k, sign = -sign) {
      const State x = end_state(witness);
      const double jerk = draw.uniform(0, 1) * (sign > 0 ? m.bounds.j_max : m.bounds.j_min);
      const double free = std::max(((sign > 0 ? m.bounds.a_max : m.bounds.a_min) - x.a) / jerk, 0.0);
      witness.phases.push_back({std::min(draw.uniform(0, 0.5), free), jerk});
    }
    m.to = end_state(witness);
    const judge::Integrated x = judge::integrate(witness);
    if (x.v_high > m.bounds.v_max || x.v_low < m.bounds.v_min || !judge::tenable(m.to, m.bounds, -1)) continue;
    const double t = static_cast<double>(x.duration);
    const Joint joint = move_together(std::span(&m, 1), {.min_duration_s = t});
    ASSERT_TRUE(joint) << name(joint.reason) << " case " << n;
    expect_arrival(joint, std::span(&m, 1), joint.duration_s);
    ASSERT_NEAR(joint.duration_s, t, 1e-7 * t) << "case " << n;
  }
}

TEST(Together, a_minimum_and_a_grid_of_durations_are_kept) {
  Draw draw(4);
  for (int n = 0; n < 20000; ++n) {
    const AxisMove axes[] = {draw.axis(n % 2), draw.axis(n % 2)};
    const double least = draw.uniform(0, 20);
    const Joint joint = move_together(axes, {.min_duration_s = least, .cycle_s = 0.001});
    ASSERT_TRUE(joint) << "case " << n;
    ASSERT_GE(joint.duration_s, least * (1 - 1e-12));
    ASSERT_NEAR(std::round(joint.duration_s * 1000), joint.duration_s * 1000, 1e-6);
    expect_arrival(joint, axes, joint.duration_s);
  }
}

TEST(Together, phase_keeps_a_straight_line) {
  Draw draw(5);
  for (int n = 0; n < 20000; ++n) {
    AxisMove axes[] = {draw.axis(true), draw.axis(true), draw.axis(true)};
    for (AxisMove& m : axes) m.from.v = m.from.a = m.to.v = m.to.a = 0;
    const double along = n % 2 ? draw.uniform(0, 0.05) : 0;  // some of them already under way on the line
    for (AxisMove& m : axes) m.from.v = along * (m.to.p - m.from.p);
    bool fits = true;
    for (const AxisMove& m : axes) fits &= judge::tenable(m.from, m.bounds, 1);
    if (!fits) continue;
    const Joint joint = move_together(axes, {.sync = Sync::Phase});
    ASSERT_TRUE(joint) << "case " << n;
    ASSERT_TRUE(joint.straight) << "case " << n;
    expect_arrival(joint, axes, joint.duration_s);
    for (int k = 1; k < 20; ++k) {
      const double t = joint.duration_s * k / 20;
      const double u = (evaluate(joint.profiles[0], t).p - axes[0].from.p) / (axes[0].to.p - axes[0].from.p);
      for (std::size_t i = 1; i < 3; ++i) {
        const double whole = axes[i].to.p - axes[i].from.p;
        ASSERT_NEAR(evaluate(joint.profiles[i], t).p, axes[i].from.p + u * whole, 1e-9 * (1 + std::abs(whole)));
      }
    }
    // No bound of any axis leaves room: the line is as fast as its tightest axis.
    double fullest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const judge::Integrated x = judge::integrate(joint.profiles[i]);
      fullest =
          std::max({fullest, (double)(x.j_high / axes[i].bounds.j_max), (double)(x.j_low / axes[i].bounds.j_min)});
    }
    ASSERT_NEAR(fullest, 1, 1e-9) << "case " << n;
  }
}

TEST(Together, what_lies_on_no_line_arrives_in_time) {
  Draw draw(6);
  const AxisMove axes[] = {draw.axis(false), draw.axis(false)};
  const Joint joint = move_together(axes, {.sync = Sync::Phase});
  ASSERT_TRUE(joint);
  EXPECT_FALSE(joint.straight);
  expect_arrival(joint, axes, joint.duration_s);
}

TEST(Together, without_synchronisation_every_axis_is_as_fast_as_alone) {
  Draw draw(7);
  for (int n = 0; n < 5000; ++n) {
    const AxisMove axes[] = {draw.axis(true), draw.axis(true)};
    const Joint joint = move_together(axes, {.sync = Sync::None});
    ASSERT_TRUE(joint);
    for (std::size_t i = 0; i < 2; ++i)
      ASSERT_NEAR(duration(joint.profiles[i]), duration(move(axes[i].from, axes[i].to, axes[i].bounds).profile), 1e-12);
  }
}

TEST(Together, a_disabled_axis_is_not_planned) {
  AxisMove axes[] = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {NAN, 0, 0}, {0, 0, 0}, false}};
  const Joint joint = move_together(axes);
  ASSERT_TRUE(joint);
  EXPECT_TRUE(joint.profiles[1].phases.empty());
  axes[1].enabled = true;
  EXPECT_EQ(move_together(axes).reason, Reason::BadBounds);
  EXPECT_EQ(move_together(axes).axis, 1);
}

TEST(Together, what_fails_leaves_no_motion_behind) {
  // That the second axis has no motion is known only when the first one is planned: it starts where it cannot stay
  // within its limits.
  AxisMove axes[] = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 1}}, {{0, 1, 0}, {0.05, 0, 0}, {1, 1, 1}}};
  axes[1].bounds.p_min = -1, axes[1].bounds.p_max = 0.1;
  const Joint joint = move_together(axes);
  EXPECT_EQ(joint.reason, Reason::StartCannotStay);
  EXPECT_EQ(joint.axis, 1);
  EXPECT_TRUE(joint.profiles.empty());
  EXPECT_EQ(joint.duration_s, 0);
}

TEST(SpeedsTogether, all_axes_have_their_speeds_at_once) {
  Draw draw(8);
  int waited = 0;
  for (int n = 0; n < 60000; ++n) {
    const AxisMove axes[] = {draw.axis(n % 2), draw.axis(n % 2), draw.axis(n % 2)};
    const double least = n % 3 ? 0 : draw.uniform(0, 5);
    const Joint joint = change_speeds_together(axes, {.min_duration_s = least});
    ASSERT_TRUE(joint) << "case " << n;
    double slowest = least;
    for (std::size_t i = 0; i < 3; ++i) {
      const judge::Integrated x = judge::integrate(joint.profiles[i]);
      const AxisBounds& b = axes[i].bounds;
      ASSERT_NEAR((double)x.v, axes[i].to.v, 1e-9 * b.v_max) << "case " << n << " axis " << i;
      ASSERT_NEAR((double)x.a, axes[i].to.a, 1e-9 * b.a_max) << "case " << n << " axis " << i;
      ASSERT_LE(x.a_high, b.a_max * (1 + 1e-9));
      ASSERT_GE(x.a_low, b.a_min * (1 + 1e-9));
      ASSERT_LE(x.j_high, b.j_max * (1 + 1e-9));
      ASSERT_GE(x.j_low, b.j_min * (1 + 1e-9));
      ASSERT_NEAR((double)x.duration, joint.duration_s, 1e-12 * (1 + joint.duration_s));
      slowest = std::max(slowest, duration(change_speed(axes[i].from, axes[i].to.v, b, axes[i].to.a).profile));
    }
    ASSERT_GE(joint.duration_s, slowest * (1 - 1e-12));
    waited += joint.duration_s > slowest * (1 + 1e-9);
  }
  EXPECT_LT(waited, 6000);
}

}  // namespace
}  // namespace gantry::motion
