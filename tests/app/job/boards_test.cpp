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

/// And what is refused is not: both bodies and the line are named, and some pair comes nearer than the clearance.
void expect_right(const test::Verdict& v, std::uint64_t boards) {
  EXPECT_EQ(v.unnamed, 0u);
  EXPECT_EQ(v.false_refusals, 0u);
  EXPECT_GT(v.refused, boards / 4) << "a slice without refusals judges nothing";
  EXPECT_GT(v.blended, boards);
  EXPECT_GT(v.in_doubt, boards / 20);
  for (const std::string& told : v.told) ADD_FAILURE() << told;
}

TEST(Boards, on_the_shipped_machine_what_is_certified_is_free_and_what_is_refused_is_not) {
  constexpr std::uint64_t kBoards = 160;
  expect_right(verdict_on(test::reference(), kBoards), kBoards);
}

/// 606352: a detour between two features led lower than half of the retract.
TEST(Boards, those_on_which_something_was_found) {
  test::Verdict v;
  for (const std::uint64_t number : {606352u})
    test::try_board(test::random_board(test::reference(), number), number, v);
  for (const std::string& told : v.told) ADD_FAILURE() << told;
}

TEST(Boards, axes_of_one_delay_change_nothing_in_that) {
  constexpr std::uint64_t kBoards = 200;
  expect_right(verdict_on(test::of_one_delay(), kBoards), kBoards);
}

}  // namespace
}  // namespace gantry
