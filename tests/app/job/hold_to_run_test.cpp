#include "app/job/hold_to_run.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "motion/profile/planner.hpp"

namespace gantry::job::hold_to_run {
namespace {

/// Of the stops that the planner of states finds from anywhere on the way to v, and beyond.
double longest_stop_s(double v, const motion::Bounds& bounds) {
  const motion::Plan faster = motion::change_speed({0, 0, 0}, v, bounds);
  EXPECT_TRUE(faster);
  const double duration_s = motion::duration(faster.profile);
  constexpr int kSteps = 600;
  double longest = 0;
  for (int n = 0; n <= kSteps; ++n) {
    const motion::Plan stop = motion::stop(motion::evaluate(faster.profile, duration_s * n / kSteps), bounds);
    EXPECT_TRUE(stop);
    longest = std::max(longest, motion::duration(stop.profile));
  }
  return longest;
}

TEST(HoldToRunSpeed, is_the_one_whose_longest_stop_lasts_as_long_as_there_is) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> within(0.01, 0.09), exponent(0, 1);
  for (int n = 0; n < 300; ++n) {
    const double j = 1e3 * std::pow(1e3, exponent(random)), a = j * 0.002 * std::pow(50, exponent(random));
    const double within_s = within(random), v = speed_that_stands(within_s, a, j);
    if (v <= 0) {
      EXPECT_LE(within_s, 2 * a / j);
      continue;
    }
    const double longest = longest_stop_s(v, {1e9, a, j});
    EXPECT_LE(longest, within_s * (1 + 1e-6)) << "a " << a << " j " << j << " v " << v;
    EXPECT_GE(longest, within_s * 0.99) << "a " << a << " j " << j << " v " << v;
  }
}

/// By hand: 80 m/s³ and 4 m/s² take 50 ms to build up the acceleration; 20 mm/s are reached with 1265 mm/s² after 15.8
/// ms, and three times that are 47.4 ms.
TEST(HoldToRunSpeed, of_an_axis_by_hand) {
  EXPECT_NEAR(speed_that_stands(0.0474342, 4000, 80000), 20, 1e-4);
  EXPECT_NEAR(speed_that_stands(0.2, 4000, 80000), 400, 1e-9) << "50 ms until it brakes, 100 ms at 4 m/s², 50 ms out";
  EXPECT_EQ(speed_that_stands(0, 4000, 80000), 0);
  EXPECT_EQ(speed_that_stands(-0.01, 4000, 80000), 0);
}

TEST(HoldToRunTime, is_shared_out_at_every_cycle_and_leaves_several_beats_to_a_silence) {
  config::Machine machine;
  machine.axes.resize(1);
  machine.axes[0].response_delay_s = 0.004;
  for (const double cycle_ms : {0.25, 1.0, 4.0, 10.0}) {
    machine.bus.cycle = Time(static_cast<std::int64_t>(cycle_ms * 1e6));
    EXPECT_GE(silence(machine.bus.cycle), 3 * kBeat) << cycle_ms;
    EXPECT_NEAR(seconds(silence(machine.bus.cycle)) + 4e-3 * cycle_ms + 0.001 + 0.004 + braking_s(machine), 0.1, 1e-12);
  }
}

}  // namespace
}  // namespace gantry::job::hold_to_run
