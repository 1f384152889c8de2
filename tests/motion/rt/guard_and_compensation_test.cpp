#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "motion/rt/compensation.hpp"
#include "motion/rt/guard.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/rt/play.hpp"

namespace gantry::motion {
namespace {

using test::machine;

TEST(Guard, lets_planned_steps_pass_and_names_the_axis_of_others) {
  const Limits m = machine();
  AxisVec last{100, 100, -20, 0, 0}, before = last, next = last;
  before[1] -= 0.7;  // 700 mm/s
  next[1] += 0.7;
  EXPECT_EQ(check_target(m, before, last, next).fault, Fault::None);
  next[1] += 1e-3;
  EXPECT_EQ(check_target(m, before, last, next).fault, Fault::TargetStep);
  EXPECT_EQ(check_target(m, before, last, next).axis, AxisId{1});
  EXPECT_EQ(check_target(m, before, last, next, 0, 0b11101).fault, Fault::None) << "axes that are not looked at";
  next[1] += 0.698;
  EXPECT_EQ(check_target(m, before, last, next, 1).fault, Fault::None) << "two ticks' displacement after a missed one";
}

TEST(Guard, lets_no_more_acceleration_pass_than_the_axis_has) {
  const Limits m = machine();
  // Axis 1 goes at 100 mm/s, and may change its steps by 4000 mm/s^2 * (1 ms)^2 = 4 um a tick.
  const AxisVec before{100, 99.9, -20, 0, 0}, last{100, 100, -20, 0, 0};
  for (const double sign : {1.0, -1.0}) {
    AxisVec next = last;
    next[1] += 0.1 + sign * 0.004;
    EXPECT_EQ(check_target(m, before, last, next).fault, Fault::None);
    next[1] = last[1] + 0.1 + sign * 0.0041;
    EXPECT_EQ(check_target(m, before, last, next).fault, Fault::TargetStep);
    EXPECT_EQ(check_target(m, before, last, next).axis, AxisId{1});
    EXPECT_EQ(check_target(m, before, last, next, 0, 0b11101).fault, Fault::None) << "axes that are not looked at";
    // Four ticks of constant acceleration: 0.1 mm and 4 um more in each, 0.44 mm altogether.
    next[1] = last[1] + 4 * 0.1 + sign * (1 + 2 + 3 + 4) * 0.004;
    EXPECT_EQ(check_target(m, before, last, next, 3).fault, Fault::None);
    next[1] += sign * 0.001;
    EXPECT_EQ(check_target(m, before, last, next, 3).fault, Fault::TargetStep);
  }
  EXPECT_EQ(check_target(m, before, last, last).fault, Fault::TargetStep) << "it stands at once";
}

TEST(Guard, refuses_what_is_no_number) {
  const Limits m = machine();
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    AxisVec last{}, next{};
    next[3] = bad;
    EXPECT_EQ(check_target(m, last, last, next).fault, Fault::TargetNotFinite);
    EXPECT_EQ(check_target(m, last, last, next).axis, AxisId{3});
  }
}

TEST(Guard, stops_at_the_soft_limits_but_lets_back_in) {
  const Limits m = machine();
  const auto at = [](double x) { return AxisVec{x, 0, 0, 0, 0}; };
  EXPECT_EQ(check_target(m, at(609.7), at(609.9), at(610.1)).fault, Fault::SoftLimit);
  EXPECT_EQ(check_target(m, at(615.5), at(615), at(614.5)).fault, Fault::None);
  EXPECT_EQ(check_target(m, at(615), at(615), at(615)).fault, Fault::None);
  const double rounded = std::nextafter(615.0, 700.0);  // it stays there, computed anew
  EXPECT_EQ(check_target(m, at(615), at(615), at(rounded)).fault, Fault::None);
  EXPECT_EQ(check_target(m, at(615), at(615), at(615 + 2e-8)).fault, Fault::None) << "a delayed one swings out";
  EXPECT_EQ(check_target(m, at(615), at(615), at(615 + 1e-5)).fault, Fault::SoftLimit);
  EXPECT_EQ(check_target(m, at(615), at(615 + 1e-6), at(615 + 2e-6)).fault, Fault::SoftLimit) << "it creeps out";
  EXPECT_EQ(check_target(m, at(614.9), at(615), at(615.1)).fault, Fault::SoftLimit);
}

/// The planned motion of the tests: every axis a sine, so that q(t) is known between ticks.
Setpoint wave(double t) {
  Setpoint s;
  for (std::size_t i = 0; i < 5; ++i) {
    s.q[i] = 10 * std::sin(20 * t + static_cast<double>(i));
    s.v[i] = 200 * std::cos(20 * t + static_cast<double>(i));
  }
  return s;
}

TEST(Compensation, makes_every_axis_lag_as_much_as_the_slowest) {
  const Limits m = machine();
  const AxisVec delay{0.004, 0.0123, 0.0, 0.0005, 0.0125};
  Compensation c(m, delay);
  EXPECT_EQ(c.delay_ticks(), 13);
  c.reset(wave(0).q);
  for (int n = 1; n < 400; ++n) {
    const Compensated out = c.step(wave(n * 0.001), 0);
    if (n < 40) continue;
    for (std::size_t i = 0; i < 5; ++i) {
      // What the axis answers delay[i] later is the plan of 13 ms before.
      const double own = 0.013 - delay[i];
      ASSERT_NEAR(out.q[i], wave(n * 0.001 - own).q[i], 1e-6) << "axis " << i << " tick " << n;
    }
  }
}

/// 61 cycles, at any cycle: what a machine file may ask for (config/check_timing.cpp).
TEST(Compensation, makes_up_for_as_many_cycles_as_a_machine_may_ask_for) {
  constexpr int kMost = 61;
  Limits m = machine();
  m.tick_s = 0.00025;
  Compensation c(m, AxisVec{kMost * m.tick_s, 20 * m.tick_s, 0});
  EXPECT_EQ(c.delay_ticks(), kMost);
  c.reset({});
  for (int n = 1; n <= 200; ++n) {
    const double p = 0.01 * n, v = 0.01 / m.tick_s;
    const Compensated out = c.step({.q = {p, p, p}, .v = {v, v, v}}, 0);
    if (n <= kMost + 2) continue;
    EXPECT_NEAR(out.q[0], p, 1e-12);
    EXPECT_NEAR(out.q[1], 0.01 * (n - (kMost - 20)), 1e-12);
    EXPECT_NEAR(out.q[2], 0.01 * (n - kMost), 1e-12);
  }
}

TEST(Compensation, of_equal_delays_changes_nothing) {
  Compensation c(machine(), AxisVec{});
  EXPECT_EQ(c.delay_ticks(), 0);
  c.reset(AxisVec{});
  for (int n = 1; n < 100; ++n) {
    Setpoint s = wave(n * 0.001);
    s.outputs = static_cast<std::uint32_t>(n);
    const Compensated out = c.step(s, 0);
    EXPECT_EQ(out.q, s.q);
    EXPECT_EQ(out.outputs, s.outputs);
  }
}

TEST(Compensation, delays_planned_outputs_but_never_a_stop) {
  Compensation c(machine(), AxisVec{0.005});
  c.reset(AxisVec{});
  Setpoint s;
  s.outputs = 3;
  for (int n = 0; n < 5; ++n) EXPECT_EQ(c.step(s, 0).outputs, 0u) << n;
  EXPECT_EQ(c.step(s, 0).outputs, 3u) << "five ticks later";
  s.outputs = 2;
  EXPECT_EQ(c.step(s, 1).outputs, 2u) << "a stop's closing comes at once";
  for (int n = 0; n < 10; ++n) EXPECT_EQ(c.step(s, 0).outputs, 2u) << "and what was on its way stays closed";
}

TEST(Compensation, of_planned_motion_never_looks_to_the_guard_like_a_step_or_a_limit_passed) {
  // At full speed, in whole ticks (so that nothing is stretched), and to the very limit, delayed by parts of a tick.
  int moves = 0;
  for (const double fraction : {0.1, 0.25, 0.5, 0.8})
    for (const double j : {5'000.0, 60'000.0, 400'000.0})
      for (int k = 0; k < 60; ++k, ++moves) {
        Limits m;
        m.axes = 2;
        m.linear[0] = true;
        const double v = 150, a = 2'500;
        const double to_speed = a * a / j < v ? v / a + a / j : 2 * std::sqrt(v / j);
        const double whole = std::ceil((to_speed + 0.02) / m.tick_s) * m.tick_s + k * m.tick_s;
        const double length = (whole - to_speed) * v;
        m.axis[0] = {-length, 0, v, a, j};
        m.axis[1] = m.axis[0];
        AxisVec from{}, to{};
        from[0] = k % 2 == 0 ? -length : 0, to[0] = -length - from[0];
        test::Player player(m, from);
        auto segments = line_move(m, from, to);
        for (Segment& s : segments) s.block = 1, s.ends_block = true;
        player.push(segments);
        player.play.begin_block(1);
        Compensation c(m, AxisVec{fraction * m.tick_s, m.tick_s});
        c.reset(from);
        AxisVec last = from, before = from;
        for (int n = 0; n < 10 + std::lround(whole / m.tick_s); ++n) {
          const AxisVec next = c.step(player.step(), 0).q;
          const Verdict verdict = check_target(m, before, last, next);
          ASSERT_EQ(verdict.fault, Fault::None)
              << "j " << j << ", " << length << " mm, tick " << n << ": " << last[0] << " to " << next[0];
          before = last;
          last = next;
        }
        ASSERT_NEAR(last[0], to[0], 1e-9);
      }
  EXPECT_EQ(moves, 720);
}

TEST(Compensation, goes_on_from_a_target_and_its_speed_whatever_was_before) {
  const Limits m = machine();
  const AxisVec delay{0.004, 0.0123, 0.0, 0.0005, 0.0125}, q{1, 2, 3, 4, 5}, v{100, -50, 10, 1, 0};
  Compensation c(m, delay);
  c.reset(AxisVec{9, 9, 9, 9, 9});
  Setpoint s;
  s.q = c.go_on(q, v, 0), s.v = v;
  for (int n = 1; n < 40; ++n) {
    for (std::size_t i = 0; i < 5; ++i) s.q[i] += v[i] * m.tick_s;
    const AxisVec out = c.step(s, 0).q;
    for (std::size_t i = 0; i < 5; ++i) ASSERT_NEAR(out[i], q[i] + v[i] * m.tick_s * n, 1e-12) << i << " " << n;
  }
}

TEST(Compensation, is_settled_when_the_slowest_axis_stands) {
  Compensation c(machine(), AxisVec{0.005, 0.001});
  c.reset(AxisVec{});
  Setpoint s;
  s.q[1] = 1;
  EXPECT_FALSE(c.step(s, 0).settled);
  int ticks = 1;
  while (!c.step(s, 0).settled) ++ticks;
  EXPECT_GE(ticks, 4);
  EXPECT_LE(ticks, 7);
  EXPECT_EQ(c.step(s, 0).q[1], 1);
}

}  // namespace
}  // namespace gantry::motion
