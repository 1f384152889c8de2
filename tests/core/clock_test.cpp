#include "core/clock.hpp"

#include <gtest/gtest.h>

namespace gantry {
namespace {

TEST(VirtualClock, moves_only_by_sleeping_and_never_back) {
  VirtualClock clock;
  const Time start = clock.now();
  EXPECT_GT(start, milliseconds(100)) << "a little before the start is not negative";
  EXPECT_EQ(clock.now(), start);
  clock.sleep_until(start + milliseconds(3));
  EXPECT_EQ(clock.now(), start + milliseconds(3));
  clock.sleep_until(start);
  EXPECT_EQ(clock.now(), start + milliseconds(3));
  EXPECT_TRUE(clock.is_virtual());
}

TEST(MonotonicClock, never_runs_back_and_sleeps_at_least_until_the_time) {
  MonotonicClock clock;
  EXPECT_FALSE(clock.is_virtual());
  Time last = clock.now();
  for (int i = 0; i < 1000; ++i) {
    const Time now = clock.now();
    ASSERT_GE(now, last);
    last = now;
  }
  const Time wanted = clock.now() + milliseconds(2);
  clock.sleep_until(wanted);
  EXPECT_GE(clock.now(), wanted);
  clock.sleep_until(wanted - milliseconds(100));  // past: returns at once
  clock.sleep_until(Time{0});
}

TEST(Clock, seconds_of_a_time) {
  EXPECT_DOUBLE_EQ(seconds(milliseconds(1500)), 1.5);
  EXPECT_DOUBLE_EQ(seconds(nanoseconds(1)), 1e-9);
}

TEST(PatientClock, goes_on_from_where_it_stood_when_the_host_did) {
  PatientClock clock;
  const MonotonicClock real;
  const Time really = real.now(), before = clock.now();
  EXPECT_TRUE(clock.stand_still(milliseconds(40)));
  clock.sleep_until(before + milliseconds(2));
  EXPECT_GE(clock.now(), before + milliseconds(2));
  EXPECT_GE(real.now() - really, milliseconds(42)) << "it sleeps by its own time";
  const Time passed = clock.now() - before;
  EXPECT_LE(passed, real.now() - really - milliseconds(40));
  EXPECT_FALSE(MonotonicClock().stand_still(milliseconds(40)));
}

}  // namespace
}  // namespace gantry
