// The motor against an integrator that knows nothing of the closed solution: classic Runge-Kutta in steps of 100 ns,
// and edges found by watching its samples.
#include "sim/drive/motor.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace gantry::sim {
namespace {

config::SimAxis axis(double lag_s, double delay_s = 0) {
  config::SimAxis truth;
  truth.lag_s = lag_s, truth.delay_s = delay_s;
  truth.neg_limit = -100, truth.pos_limit = 100, truth.home_switch = -50;
  return truth;
}

double rk4(double x, double t, double h, double tau, const CommandPiece& c) {
  const auto f = [&](double time, double place) { return (c.p + c.v * time + 0.5 * c.a * time * time - place) / tau; };
  const double k1 = f(t, x), k2 = f(t + h / 2, x + h / 2 * k1), k3 = f(t + h / 2, x + h / 2 * k2),
               k4 = f(t + h, x + h * k3);
  return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
}

TEST(Motor, follows_quadratic_commands_as_an_integrator_says) {
  std::mt19937 random(4711);
  std::uniform_real_distribution<double> place(-20, 20), speed(-300, 300), accel(-5000, 5000), lag(0.001, 0.02);
  for (int i = 0; i < 200; ++i) {
    const double tau = lag(random), start = place(random);
    Motor motor(axis(tau));
    motor.restore(start);
    const CommandPiece c{start + 0.1 * place(random), speed(random), accel(random)};
    motor.run(c, 0.001, 0);
    double x = start;
    for (int k = 0; k < 10000; ++k) x = rk4(x, k * 1e-7, 1e-7, tau, c);
    EXPECT_NEAR(motor.position(), x, 1e-9) << "seed 4711, case " << i;
    EXPECT_NEAR(motor.velocity(), (c.p + c.v * 1e-3 + 0.5 * c.a * 1e-6 - x) / tau, 1e-5);
  }
}

TEST(Motor, stops_at_the_instant_of_the_edge) {
  std::mt19937 random(42);
  std::uniform_real_distribution<double> speed(5, 300), accel(-20000, 20000), edge(0.001, 0.2);
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    config::SimAxis truth = axis(0.004);
    truth.start = 0;
    truth.pos_limit = edge(random);
    Motor motor(truth);
    const CommandPiece c{0.05, speed(random), accel(random)};
    const Ran ran = motor.run(c, 0.004, kPosLimit);
    double x = 0, t = 0, crossed = -1;
    for (int k = 0; k < 40000 && crossed < 0; ++k) {
      const double next = rk4(x, t, 1e-7, 0.004, c);
      if (next >= truth.pos_limit) crossed = t + 1e-7 * (truth.pos_limit - x) / (next - x);
      x = next, t += 1e-7;
    }
    if (crossed < 0) {
      EXPECT_EQ(ran.changed, 0u) << "seed 42, case " << i;
      EXPECT_EQ(ran.elapsed_s, 0.004);
      continue;
    }
    ++met;
    EXPECT_EQ(ran.changed, kPosLimit) << "seed 42, case " << i;
    EXPECT_NEAR(ran.elapsed_s, crossed, 1e-10);
    EXPECT_EQ(motor.position(), truth.pos_limit);
    EXPECT_NE(motor.inputs() & kPosLimit, 0u);
  }
  EXPECT_GT(met, 100);
}

TEST(Motor, sees_an_edge_that_is_touched_and_left_within_one_step) {
  config::SimAxis truth = axis(0);  // without a lag the course is the parabola itself
  truth.pos_limit = 0.009;
  Motor motor(truth);
  const CommandPiece there_and_back{0, 20, -20000};  // top at 1 ms: 0.01
  const Ran closes = motor.run(there_and_back, 0.002, kPosLimit);
  EXPECT_EQ(closes.changed, kPosLimit);
  EXPECT_NEAR(closes.elapsed_s, 0.001 - std::sqrt(0.001 / 10000), 1e-11);
  const double t = closes.elapsed_s;
  const CommandPiece rest{20 * t - 10000 * t * t, 20 - 20000 * t, -20000};
  const Ran opens = motor.run(rest, 0.002 - t, kPosLimit);
  EXPECT_EQ(opens.changed, kPosLimit);
  EXPECT_NEAR(t + opens.elapsed_s, 0.001 + std::sqrt(0.001 / 10000), 1e-11);
  EXPECT_EQ(motor.inputs() & kPosLimit, 0u);
}

TEST(Motor, every_edge_is_reported_once_however_often_it_is_crossed) {
  config::SimAxis truth = axis(0.003);
  truth.home_switch = 0;
  truth.start = 1;
  Motor motor(truth);
  std::vector<std::uint32_t> levels{motor.inputs() & kHome};
  double t = 0;
  for (int cycle = 0; cycle < 2000; ++cycle) {  // a sine of 5 Hz about the switch, in chords
    const double p0 = std::cos(31.4 * t), p1 = std::cos(31.4 * (t + 0.001));
    double left = 0.001, at = 0;
    for (int guard = 0; left > 0 && guard < 10; ++guard) {
      const double v = (p1 - p0) / 0.001;
      const Ran ran = motor.run({p0 + v * at, v, 0}, left, kHome);
      if (ran.changed != 0) levels.push_back(motor.inputs() & kHome);
      left -= ran.elapsed_s, at += ran.elapsed_s;
    }
    t += 0.001;
  }
  for (std::size_t i = 1; i < levels.size(); ++i) EXPECT_NE(levels[i], levels[i - 1]) << i;
  EXPECT_EQ(levels.size(), 1u + 20u);  // 2 s of 4.997 Hz: two crossings a period
}

TEST(Motor, a_standing_command_is_reached_exactly) {
  Motor motor(axis(0.005));
  motor.restore(3);
  for (int i = 0; i < 1000; ++i) motor.run({7.123456789, 0, 0}, 0.001, kPosLimit);
  EXPECT_EQ(motor.position(), 7.123456789);
  EXPECT_EQ(motor.velocity(), 0);
}

TEST(Motor, a_pure_delay_shifts_the_whole_course) {
  Motor prompt(axis(0.004)), late(axis(0.004, 0.0025));
  double p = 0;
  std::vector<double> a, b;
  for (int i = 0; i < 400; ++i) {
    const double next = std::sin(0.01 * i);
    const CommandPiece c{p, (next - p) / 0.0005, 0};
    prompt.run(c, 0.0005, 0), late.run(c, 0.0005, 0);
    a.push_back(prompt.position()), b.push_back(late.position());
    p = next;
  }
  for (std::size_t i = 5; i < b.size(); ++i) EXPECT_NEAR(b[i], a[i - 5], 1e-12) << i;
}

TEST(Motor, the_probe_closes_where_the_world_says) {
  Motor motor(axis(0.004));
  EXPECT_EQ(motor.inputs() & kProbe, 0u);
  motor.set_contact(-1.25);
  const Ran ran = motor.run({0, -500, 0}, 0.02, kProbe);
  EXPECT_EQ(ran.changed, kProbe);
  EXPECT_EQ(motor.position(), -1.25);
  motor.set_contact(-1e9);
  EXPECT_EQ(motor.inputs() & kProbe, 0u);
}

TEST(Motor, a_stalled_axis_stays_and_catches_up_afterwards) {
  Motor motor(axis(0.004));
  motor.set_stalled(true);
  motor.run({5, 100, 0}, 0.1, kPosLimit);
  EXPECT_EQ(motor.position(), 0);
  motor.set_stalled(false);
  for (int i = 0; i < 200; ++i) motor.run({5, 0, 0}, 0.001, 0);
  EXPECT_EQ(motor.position(), 5);
}

TEST(Motor, two_runs_of_the_same_commands_are_equal_to_the_bit) {
  Motor one(axis(0.0043, 0.0017)), two(axis(0.0043, 0.0017));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> step(-0.3, 0.3);
  double p = 0;
  for (int i = 0; i < 5000; ++i) {
    const double next = p + step(random);
    const CommandPiece c{p, (next - p) / 0.001, 0};
    one.run(c, 0.001, kHome), two.run(c, 0.001, kHome);
    ASSERT_EQ(one.position(), two.position());
    p = next;
  }
}

}  // namespace
}  // namespace gantry::sim
