// A slice of the campaign (bench/plan/plan_campaign.cpp runs the long one).
#include "tests/motion/plan/plan_trial.hpp"

#include <gtest/gtest.h>

namespace gantry::test {
namespace {

TEST(PlanTrial, of_random_pairs_none_is_called_free_that_meets) {
  const PairTally t = try_pairs(40000, 1);
  std::printf("%d free, %d hits, %d close calls\n", t.free, t.hit, t.close_calls);
  EXPECT_EQ(t.false_free, 0);
  EXPECT_EQ(t.false_hits, 0);
  EXPECT_EQ(t.disagreements, 0);
  EXPECT_GT(t.free, 10000);
  EXPECT_GT(t.hit, 5000);
}

TEST(PlanTrial, of_random_plans_none_collides_and_no_proof_is_wrong) {
  const PlanTally t = try_plans(300, 1);
  std::printf("%d paths, %d proved that there is none, %d ends collide, %d undecided\n", t.ok, t.no_path, t.taken,
              t.budget);
  EXPECT_EQ(t.colliding, 0);
  EXPECT_EQ(t.refused, 0);
  EXPECT_EQ(t.disproved, 0);
  EXPECT_EQ(t.longer, 0);
  EXPECT_EQ(t.different, 0);
  EXPECT_EQ(t.budget, 0);
  EXPECT_GT(t.ok, 80);
  EXPECT_GT(t.no_path, 10);
}

}  // namespace
}  // namespace gantry::test
