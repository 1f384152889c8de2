// A slice of the campaign of disturbed motion; the whole one is bench/path_play.
#include "tests/motion/rt/trial.hpp"

#include <gtest/gtest.h>

#include "motion/types.hpp"

namespace gantry::motion::test {
namespace {

TEST(Trial, motion_disturbed_at_random_keeps_limits_and_path_and_stops_in_time) {
  std::size_t stops = 0, line_stops = 0, changes = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Verdict v = trial(seed);
    EXPECT_EQ(v.wrong, "") << "seed " << seed;
    stops += v.stops, line_stops += v.line_stops, changes += v.changes;
  }
  EXPECT_GT(stops, 400u);
  EXPECT_GT(line_stops, 150u);
  EXPECT_GT(changes, 800u);
}

// The planned jerk changes its sign within the last tick of a change of rate: a straight stop behind it must not wait.
TEST(Trial, a_stop_on_a_line_right_behind_a_change_of_rate_begins_at_once) {
  for (const std::uint64_t seed : {1000247u, 2000971u}) EXPECT_EQ(trial(seed).wrong, "") << "seed " << seed;
}

}  // namespace
}  // namespace gantry::motion::test
