// Two tables of the same standard (IEC 61800-7-201, 10.4), one told as what a method looks for and one as what the
// motor does step by step, must agree.
#include "sim/drive/homing_methods.hpp"

#include <gtest/gtest.h>

#include "config/homing_method.hpp"
#include "sim/drive/motor.hpp"

namespace gantry::sim {
namespace {

std::uint32_t input(config::HomingSwitch s) {
  switch (s) {
    case config::HomingSwitch::NegativeLimit: return kNegLimit;
    case config::HomingSwitch::PositiveLimit: return kPosLimit;
    case config::HomingSwitch::Home: return kHome;
    case config::HomingSwitch::None: break;
  }
  return 0;
}

TEST(HomingMethods, go_where_the_machine_file_is_checked_for) {
  int modelled = 0;
  for (int number = 1; number <= 37; ++number) {
    const HomingMethod* steps = homing_method(number);
    if (steps == nullptr) continue;
    ++modelled;
    const config::HomingMethod told = config::homing_method(number);
    EXPECT_EQ(input(told.looks_for), steps->reference) << number;
    EXPECT_EQ(told.toward, steps->off.empty() ? 0 : steps->off.front().direction) << number;
    EXPECT_FALSE(told.index_pulse) << number;
    const bool limit = told.looks_for != config::HomingSwitch::Home;
    EXPECT_EQ(limit ? 0u : input(told.turns_at), steps->bounce) << number;
  }
  EXPECT_EQ(modelled, 15);
}

TEST(HomingMethods, mirrored_go_the_other_way_and_back) {
  for (int number = 1; number <= 37; ++number) {
    const int other = config::mirrored(number);
    const auto method = config::homing_method(number);
    EXPECT_EQ(other == 0, method.toward == 0) << number;
    if (other == 0) continue;
    EXPECT_EQ(config::mirrored(other), number);
    const auto back = config::homing_method(other);
    EXPECT_EQ(back.toward, -method.toward) << number;
    EXPECT_EQ(back.index_pulse, method.index_pulse) << number;
    EXPECT_EQ(back.looks_for == config::HomingSwitch::Home, method.looks_for == config::HomingSwitch::Home) << number;
  }
}

/// Step by step in a mirror: the same inputs and speeds, with the limits and the directions exchanged.
TEST(HomingMethods, mirrored_do_the_same_step_by_step) {
  for (int number = 17; number <= 30; ++number) {
    const HomingMethod *a = homing_method(number), *b = homing_method(config::mirrored(number));
    ASSERT_TRUE(a && b) << number;
    for (const auto list : {&HomingMethod::off, &HomingMethod::on, &HomingMethod::bounced}) {
      ASSERT_EQ((a->*list).size(), (b->*list).size()) << number;
      for (std::size_t i = 0; i < (a->*list).size(); ++i) {
        const HomingPhase &p = (a->*list)[i], &q = (b->*list)[i];
        const std::uint32_t seen = p.input == kNegLimit ? kPosLimit : p.input == kPosLimit ? kNegLimit : p.input;
        EXPECT_EQ(q.direction, -p.direction) << number;
        EXPECT_EQ(q.input, seen) << number;
        EXPECT_EQ(q.fast, p.fast) << number;
        EXPECT_EQ(q.until_closed, p.until_closed) << number;
      }
    }
  }
}

}  // namespace
}  // namespace gantry::sim
