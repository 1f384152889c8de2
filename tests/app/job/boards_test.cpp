// A short slice of the campaign of bench/boards on every push.
#include <gtest/gtest.h>

#include "tests/app/job/board_trial.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry {
namespace {

/// What is certified is free, whatever the machine.
test::Verdict verdict_on(const config::Machine& machine, std::uint64_t boards) {
  test::Verdict v;
  for (std::uint64_t i = 0; i < boards; ++i) test::try_board(test::random_board(machine, i), i, v);
  EXPECT_EQ(v.collisions, 0u);
  EXPECT_EQ(v.misread, 0u);
  EXPECT_EQ(v.too_near, 0u);
  EXPECT_GT(v.touched, boards / 2);
  return v;
}

TEST(Boards, what_is_certified_is_free_and_what_is_refused_is_not) {
  constexpr std::uint64_t kBoards = 1000;
  const test::Verdict v = verdict_on(test::of_one_delay(), kBoards);
  EXPECT_EQ(v.unnamed, 0u);
  EXPECT_EQ(v.false_refusals, 0u);
  EXPECT_GT(v.refused, kBoards / 4) << "a slice without refusals judges nothing";
  EXPECT_GT(v.blended, kBoards);
  EXPECT_GT(v.in_doubt, kBoards / 20);
  for (const std::string& told : v.told) ADD_FAILURE() << told;
}

/// Axes of unlike delay make a proof keep some micrometres more: it refuses more, and certifies nothing that is not
/// free.
TEST(Boards, what_is_certified_for_axes_of_unlike_delay_is_free) { verdict_on(test::reference(), 500); }

}  // namespace
}  // namespace gantry
