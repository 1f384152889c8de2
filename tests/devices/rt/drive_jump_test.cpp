// What is seen of an encoder that jumps, against what is told: every trouble that a drive can show, with a jump in the
// same cycle, or later while it persists, or while nobody could look. The judge of what is told is the same drive
// without the jump.
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/devices/rt/drive_bench.hpp"

namespace gantry::devices {
namespace {

constexpr std::int32_t kStepMax = 2000, kJump = 12'000, kHere = 100'000;
constexpr int kEnabled = 0x1237;

/// What is wrong with a drive that is enabled and in CSP.
struct Trouble {
  const char* name;
  int status = kEnabled;
  int code = 0;
  int mode = 8;
  bool warns = false;  ///< it would not stop the machine
};

const std::vector<Trouble> kTroubles{
    {"nothing"},
    {"fault, known code", 0x0238, 0x3220},
    {"fault, unknown code", 0x0238, 0x7777},
    {"fault without code", 0x0238, 0},
    {"fault reaction", 0x023F, 0x3210},
    {"emergency input without fault bit", 0x0250, 0xFF23},
    {"warning", kEnabled, 0xFF31, 8, true},
    {"impossible step", 0x0240, 0},
    {"no state at all", 0x0265, 0},
    {"another mode", kEnabled, 0, 1},
    {"homing mode unasked", kEnabled, 0, 6},
    {"quick stop", 0x0217, 0},
    {"switched off", 0x0250, 0},
};

const std::vector<DriveGoal> kGoals{DriveGoal::Enabled, DriveGoal::QuickStop, DriveGoal::Disabled,
                                    DriveGoal::FaultReset};

struct Bench : DriveBench {
  explicit Bench(std::int32_t start = kHere) : DriveBench(2000, false, {.step_max = 1.0}) {
    layout.codes.push_back({0xFF31, Fault::DriveWarning, true});
    drive = Drive(layout, AxisScale(2000, false), {.step_max = 1.0});
    position(start);
    enable();
    for (int i = 0; i < 200; ++i) cycle(command);  // the mode has been right for long
  }
  void show(const Trouble& t) {
    status(t.status);
    mode(static_cast<std::int8_t>(t.mode));
    layout.error_code.set(inputs, static_cast<std::uint16_t>(t.code));
  }
  DriveCommand command{.goal = DriveGoal::Enabled, .target = kHere / 2000.0};
};

Fault expected_with_jump(const Trouble& t, Fault without) {
  return without == Fault::None || t.warns ? Fault::EncoderJump : without;
}

TEST(DriveJump, is_seen_with_any_trouble_at_any_time_and_never_hides_it) {
  int cases = 0, none = 0;
  for (const Trouble& t : kTroubles)
    for (const DriveGoal goal : kGoals)
      for (const int later : {0, 1, 2, 7, 50, 1500})  // cycles between the trouble and the jump
        for (const std::int32_t jump : {kJump, -kJump, kStepMax + 1, -kStepMax - 1})
          for (const std::int32_t start : {kHere, std::int32_t{0x7FFF'FF00}}) {
            SCOPED_TRACE(std::string(t.name) + ", goal " + std::to_string(int(goal)) + ", " + std::to_string(later) +
                         " later, jump " + std::to_string(jump) + " from " + std::to_string(start));
            Bench with(start), without(start);
            with.command.goal = without.command.goal = goal;
            with.show(t), without.show(t);
            for (int i = 0; i < later; ++i) {
              const Feedback a = with.cycle(with.command), b = without.cycle(without.command);
              ASSERT_FALSE(a.jumped);
              ASSERT_EQ(a.fault, b.fault);
            }
            with.position(wrap(Counts{std::int64_t{start} + jump}));
            const Feedback seen = with.cycle(with.command), twin = without.cycle(without.command);
            ASSERT_TRUE(seen.jumped);
            ASSERT_FALSE(twin.jumped);
            ASSERT_EQ(seen.fault, expected_with_jump(t, twin.fault));
            ASSERT_FALSE(with.cycle(with.command).jumped) << "it is seen once";
            ++cases;
            none += twin.fault == Fault::None;
          }
  EXPECT_EQ(cases, 13 * 4 * 6 * 4 * 2);
  EXPECT_GT(none, 0);
  EXPECT_LT(none, cases / 2);
}

TEST(DriveJump, while_inputs_were_stale_is_seen_at_the_first_that_are_fresh_whatever_those_show) {
  for (const Trouble& t : kTroubles)
    for (const int stale : {1, 2, 5, 20})
      for (const bool beyond : {false, true}) {
        SCOPED_TRACE(std::string(t.name) + ", " + std::to_string(stale) + " stale");
        Bench b;
        for (int i = 0; i < stale; ++i) {
          b.position(7);  // what is not fresh says nothing
          EXPECT_FALSE(b.cycle(b.command, false).jumped);
        }
        b.show(t);
        b.position(kHere + kStepMax * (1 + stale) + beyond);
        EXPECT_EQ(b.cycle(b.command).jumped, beyond);
      }
}

/// At rest there is nothing to catch up with, and losses that come again and again excuse no more than one of them.
TEST(DriveJump, losses_that_come_again_do_not_add_up) {
  for (const int apart : {2, 3, 4, 6})
    for (const bool torque : {true, false})
      for (const int after : {0, 1, 2, 5}) {
        SCOPED_TRACE(testing::Message() << "every " << apart << ", torque " << torque << ", fresh ones " << after);
        Bench b;
        if (!torque) b.show({"switched off", 0x0250}), b.command.goal = DriveGoal::Disabled;
        for (int i = 0; i < 1000 * apart; ++i) b.cycle(b.command, i % apart != 0);
        b.cycle(b.command, false);
        for (int i = 0; i < after; ++i) b.cycle(b.command);
        b.position(kHere + 2 * kStepMax + 1);
        EXPECT_TRUE(b.cycle(b.command).jumped);
      }
}

/// The same while it moves, behind a target that is 4 cycles of travel ahead: what does not lead there is a jump.
TEST(DriveJump, a_drive_that_catches_up_may_come_to_its_target_and_no_farther) {
  for (const auto& [to, jumped] : {std::pair{kHere + 4 * kStepMax, false},
                                   {kHere + 5 * kStepMax, false},
                                   {kHere + 5 * kStepMax + 1, true},
                                   {kHere - kStepMax, false},
                                   {kHere - kStepMax - 1, true}}) {
    SCOPED_TRACE(to);
    Bench b;
    b.command.target += 4 * kStepMax / 2000.0;
    b.cycle(b.command, false);
    b.cycle(b.command);
    b.position(to);
    EXPECT_EQ(b.cycle(b.command).jumped, jumped);
  }
}

TEST(DriveJump, travel_as_fast_as_the_axis_can_is_none_with_any_trouble) {
  for (const Trouble& t : kTroubles) {
    SCOPED_TRACE(t.name);
    Bench b;
    std::int32_t at = kHere;
    for (int i = 0; i < 100; ++i) {
      if (i == 20) b.show(t);
      b.position(at += i % 2 == 0 ? kStepMax : -kStepMax);
      EXPECT_FALSE(b.cycle(b.command).jumped) << i;
    }
  }
}

TEST(DriveJump, the_first_reading_is_none_and_neither_is_the_first_after_the_drive_was_lost) {
  DriveBench fresh(2000, false, {.step_max = 1.0});
  fresh.position(1'000'000);
  EXPECT_FALSE(fresh.cycle({}).jumped);

  for (const int away : {0, 1, 3, 5000}) {
    SCOPED_TRACE(away);
    Bench b;
    b.drive.lose();
    for (int i = 0; i < away; ++i) b.cycle(b.command, false);
    b.status(0x0250);
    b.position(-700'000);
    const Feedback back = b.cycle(b.command);
    EXPECT_FALSE(back.jumped);
    EXPECT_EQ(back.fault, Fault::None);
    b.position(-700'000 + kJump);  // it is known again, and has nothing to catch up with
    EXPECT_TRUE(b.cycle(b.command).jumped);
  }
}

TEST(DriveJump, a_drive_in_homing_may_set_its_counter_and_one_that_is_back_may_not) {
  Bench b;
  b.command.mode = wire::cia402::kHoming;
  b.cycle(b.command);
  b.position(kHere + kJump);  // it does not show mode 6 yet
  EXPECT_TRUE(b.cycle(b.command).jumped);
  b.mode(6);
  b.cycle(b.command);
  b.position(0);
  EXPECT_FALSE(b.cycle(b.command).jumped);
  b.show({"fault while homing", 0x0238, 0x7777, 6});
  b.position(50'000);
  EXPECT_FALSE(b.cycle(b.command).jumped) << "an axis in homing has no reference to lose";
  b.show({"nothing", kEnabled, 0, 6});
  b.command.mode = wire::cia402::kCsp;
  b.cycle(b.command);
  b.position(0);
  EXPECT_FALSE(b.cycle(b.command).jumped) << "it still shows mode 6, which was asked for";
  b.mode(8);
  b.cycle(b.command);
  b.position(kJump);
  EXPECT_TRUE(b.cycle(b.command).jumped);
  b.mode(6);  // and by itself it has no business there
  b.cycle(b.command);
  b.position(0);
  EXPECT_TRUE(b.cycle(b.command).jumped);
}

TEST(DriveJump, is_not_judged_without_a_limit) {
  DriveBench b;
  b.cycle({});
  b.position(1'000'000'000);
  EXPECT_FALSE(b.cycle({}).jumped);
}

}  // namespace
}  // namespace gantry::devices
