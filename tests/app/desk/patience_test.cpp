#include "app/desk/patience.hpp"

#include <gtest/gtest.h>

namespace gantry::desk {
namespace {

using namespace std::chrono_literals;

TEST(Patience, ends_after_five_seconds_of_turns_in_which_nothing_was_heard) {
  VirtualClock clock;
  Patience patience(clock);
  int turns = 0;
  for (; turns < 1000 && !patience.over(); ++turns) clock.sleep_until(clock.now() + 25ms);
  EXPECT_EQ(turns, 200);
}

TEST(Patience, begins_anew_with_every_sign_of_life) {
  VirtualClock clock;
  Patience patience(clock);
  for (int turn = 0; turn < 10'000; ++turn) {
    clock.sleep_until(clock.now() + 25ms);
    if (turn % 199 == 0) patience.heard();
    ASSERT_FALSE(patience.over()) << turn;
  }
}

/// A client that was suspended for an hour has not listened for an hour.
TEST(Patience, does_not_count_the_time_in_which_its_own_program_stood_still) {
  VirtualClock clock;
  Patience patience(clock);
  for (int i = 0; i < 49; ++i) {
    clock.sleep_until(clock.now() + 1h);
    ASSERT_FALSE(patience.over()) << i;
  }
  clock.sleep_until(clock.now() + 1h);
  EXPECT_TRUE(patience.over()) << "each turn counts for 100 ms";
}

}  // namespace
}  // namespace gantry::desk
