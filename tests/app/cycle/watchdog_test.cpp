// R62: the thread that speaks for a loop that does not. Real time, but nothing here depends on how punctual the host
// is: what must come is waited for, what must not come has seconds of room.
#include "app/cycle/watchdog.hpp"

#include <cstdio>
#include <gtest/gtest.h>
#include <thread>

#include "tests/app/cycle/one_drive.hpp"

namespace gantry::test {
namespace {

constexpr int kPatience_ms = 20'000;

TEST(Watchdog, a_beat_that_stays_away_is_answered_by_one_frame) {
  OneDrive drive;
  MonotonicClock clock;
  constexpr Time kLimit = milliseconds(4);  // of the reference machine on hardware
  cycle::Watchdog dog(drive.stop, clock, kLimit);
  drive.beat(clock.now());
  const auto frame = drive.wire.read(kPatience_ms);
  const Time heard = clock.now();
  EXPECT_EQ(frame, OneDrive::expected());
  EXPECT_GE(heard - drive.stop.last_beat(), kLimit) << "not before the bound";
  std::printf("the stop frame was there %.3f ms after the last beat; the bound is %.0f ms\n",
              1e3 * seconds(heard - drive.stop.last_beat()), 1e3 * seconds(kLimit));
  EXPECT_TRUE(drive.stop.sent()) << "the loop can see it";
  EXPECT_TRUE(drive.wire.read(300).empty()) << "once";
  EXPECT_EQ(dog.strikes(), 1u);
}

TEST(Watchdog, watches_again_when_the_loop_is_back) {
  OneDrive drive;
  MonotonicClock clock;
  cycle::Watchdog dog(drive.stop, clock, milliseconds(4));
  for (std::uint32_t strike = 1; strike <= 5; ++strike) {
    drive.beat(clock.now());
    EXPECT_EQ(drive.wire.read(kPatience_ms), OneDrive::expected());
    while (dog.strikes() < strike) std::this_thread::yield();
    EXPECT_TRUE(drive.stop.take_sent());
    EXPECT_FALSE(drive.stop.take_sent()) << "true once";
  }
}

TEST(Watchdog, a_loop_that_beats_is_left_alone) {
  OneDrive drive;
  MonotonicClock clock;
  cycle::Watchdog dog(drive.stop, clock, milliseconds(500));
  for (int i = 0; i < 300; ++i) {  // three times the limit
    drive.beat(clock.now());
    EXPECT_TRUE(drive.wire.read(5).empty());
  }
  EXPECT_EQ(dog.strikes(), 0u);
  EXPECT_FALSE(drive.stop.sent());
}

TEST(Watchdog, before_the_first_beat_nobody_is_missed) {
  OneDrive drive;
  MonotonicClock clock;
  cycle::Watchdog dog(drive.stop, clock, milliseconds(1));
  EXPECT_TRUE(drive.wire.read(50).empty());
  EXPECT_EQ(dog.strikes(), 0u);
}

}  // namespace
}  // namespace gantry::test
