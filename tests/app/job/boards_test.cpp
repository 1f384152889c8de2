// A short slice of the campaign of bench/boards on every push.
#include <gtest/gtest.h>

#include "tests/app/job/board_trial.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry {
namespace {

TEST(Boards, what_is_certified_is_free_and_what_is_refused_is_not) {
  const config::Machine machine = test::reference();
  test::Verdict v;
  constexpr std::uint64_t kBoards = 1500;
  for (std::uint64_t i = 0; i < kBoards; ++i) test::try_board(test::random_board(machine, i), i, v);
  EXPECT_EQ(v.collisions, 0u);
  EXPECT_EQ(v.misread, 0u);
  EXPECT_EQ(v.too_near, 0u);
  EXPECT_EQ(v.unnamed, 0u);
  EXPECT_EQ(v.false_refusals, 0u);
  EXPECT_GT(v.refused, kBoards / 4) << "a slice without refusals judges nothing";
  EXPECT_GT(v.touched, kBoards / 2);
  EXPECT_GT(v.blended, kBoards);
  EXPECT_GT(v.in_doubt, kBoards / 20);
  for (const std::string& told : v.told) ADD_FAILURE() << told;
}

}  // namespace
}  // namespace gantry
