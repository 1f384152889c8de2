#include "devices/rt/drive.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/devices/rt/drive_bench.hpp"

namespace gantry::devices {
namespace {

TEST(Drive, target_is_the_actual_position_until_it_is_enabled_and_in_csp) {
  DriveBench b;
  b.position(123'456);
  for (const int word : {0x0250, 0x0231, 0x0233}) {
    b.status(word);
    b.cycle({.goal = DriveGoal::Enabled, .target = 999});
    EXPECT_EQ(b.target(), 123'456);
  }
  b.mode(1);  // enabled, but the drive still shows another mode
  b.status(0x1237);
  EXPECT_FALSE(b.cycle({.goal = DriveGoal::Enabled, .target = 999}).takes_targets);
  EXPECT_EQ(b.target(), 123'456);
  b.mode(8);
  EXPECT_TRUE(b.cycle({.goal = DriveGoal::Enabled, .target = b.drive.commanded()}).takes_targets);
  EXPECT_EQ(b.target(), 123'456);
  b.cycle({.goal = DriveGoal::Enabled, .target = 62.0});
  EXPECT_EQ(b.target(), 124'000);
}

// The invariant itself, against any drive: a commanded position goes out only while the drive is enabled in CSP.
TEST(Drive, no_statusword_mode_or_goal_makes_it_send_a_position_to_a_drive_that_is_not_enabled) {
  const unsigned seed = 607;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  DriveBench b;
  bool was_enabled = false;
  for (int i = 0; i < 1'000'000; ++i) {
    if (random() % 4 == 0) b.status(static_cast<std::uint16_t>(random()));
    if (random() % 64 == 0) b.enable(), was_enabled = true;
    if (random() % 16 == 0) b.mode(static_cast<std::int8_t>(random() % 10));
    const auto actual = static_cast<std::int32_t>(random());
    b.position(actual);
    const DriveCommand command{.goal = static_cast<DriveGoal>(random() % 6),
                               .mode = static_cast<std::int8_t>(random() % 4 == 0 ? 6 : 8),
                               .target = static_cast<double>(random() % 1000),
                               .mode_bits = static_cast<std::uint16_t>(random() % 2 == 0 ? 0x10 : 0)};
    const std::int32_t last = b.target();
    const Feedback f = b.cycle(command);
    const bool enabled = decode(f.statusword) == DriveState::OperationEnabled;
    // With torque and not in the homing mode, what was sent last stands: its position may be one that sinks.
    const bool stands = enabled && was_enabled && !(f.mode == 6 && command.mode == 6) && b.target() == last;
    ASSERT_TRUE((enabled && f.mode == 8) || stands || b.target() == actual);
    was_enabled = enabled;
    ASSERT_TRUE(enabled || (b.controlword() & 0x10) == 0);
    ASSERT_TRUE(enabled || decode(f.statusword) == DriveState::SwitchedOn || (b.controlword() & 0x08) == 0);
  }
}

/// The two sides of a beam get one coordinate while both have torque; the counter of one of them may show anything.
TEST(Drive, a_coordinate_that_is_given_to_a_drive_with_torque_moves_no_target) {
  DriveBench b;
  b.position(-12'000);
  b.enable();
  b.cycle({.goal = DriveGoal::Enabled, .target = b.drive.commanded()});
  b.position(-24'000);  // 2000 to the mm
  b.cycle({.goal = DriveGoal::Enabled, .target = b.drive.commanded()});
  ASSERT_EQ(b.target(), -12'000);
  b.drive.call_target(154.0);
  EXPECT_DOUBLE_EQ(b.drive.commanded(), 154.0);
  EXPECT_DOUBLE_EQ(b.drive.feedback().position, 148.0);
  b.cycle({.goal = DriveGoal::Enabled, .target = b.drive.commanded()});
  EXPECT_EQ(b.target(), -12'000);
}

/// Under load 6064h stands a few counts below the target. A target that followed it would sink with it, cycle by cycle.
TEST(Drive, while_a_drive_with_torque_changes_its_mode_the_target_stands) {
  DriveBench b;
  std::int32_t shown = 5000;
  const auto cycles = [&](std::int8_t asked, int n) {
    for (int i = 0; i < n; ++i) {
      b.position(shown);
      b.cycle({.goal = DriveGoal::Enabled, .mode = asked, .target = b.drive.commanded()});
      shown = b.target() - 3;
    }
  };
  b.position(shown);
  b.mode(0);  // as after power-up
  b.enable();
  cycles(8, 90);
  EXPECT_NEAR(b.target(), 5000, 3);
  b.mode(8);
  cycles(8, 10);
  EXPECT_NEAR(b.target(), 5000, 3);
  cycles(6, 90);  // it stays in CSP yet
  EXPECT_NEAR(b.target(), 5000, 3);
  b.mode(6);
  shown = -700;  // it is homed, and has set its counter
  for (int i = 0; i < 50; ++i) b.position(shown), b.cycle({.goal = DriveGoal::Enabled, .mode = 6});
  cycles(8, 90);  // it shows homing yet, and may be in CSP
  EXPECT_NEAR(b.target(), -700, 3);
  b.mode(8);
  cycles(8, 10);
  EXPECT_NEAR(b.target(), -700, 3);
  b.status(0x0250);  // without torque it is where it is, as ever
  b.position(40);
  b.cycle({.goal = DriveGoal::Enabled, .target = 9});
  EXPECT_EQ(b.target(), 40);
}

/// A statusword that is stuck, a controlword that was not heard: it may have its torque yet, and an axis that was held
/// by hand, or carries a load, would be led along.
TEST(Drive, one_that_goes_on_to_call_itself_enabled_keeps_its_last_target_whatever_it_was_asked_for) {
  for (const DriveGoal goal : {DriveGoal::Disabled, DriveGoal::QuickStop, DriveGoal::FaultReset}) {
    DriveBench b;
    b.position(5000);
    b.enable();
    b.cycle({.goal = DriveGoal::Enabled, .target = 2.6});
    ASSERT_EQ(b.target(), 5200);
    for (std::int32_t pushed = 5200; pushed > 2000; pushed -= 100) {
      b.position(pushed);
      b.cycle({.goal = goal, .target = 0});
      ASSERT_EQ(b.target(), 5200);
    }
    b.status(0x0250);  // now it says that it has none
    b.cycle({.goal = goal});
    EXPECT_EQ(b.target(), 2100);
  }
}

TEST(Drive, a_target_that_is_no_number_leaves_the_last_one) {
  DriveBench b;
  b.enable();
  b.cycle({.goal = DriveGoal::Enabled, .target = 1.0});
  b.cycle({.goal = DriveGoal::Enabled, .target = std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(b.target(), 2000);
}

TEST(Drive, stale_inputs_keep_the_last_feedback_and_the_targets_go_on) {
  DriveBench b;
  b.position(4000);
  b.enable();
  b.status(0x0238);
  b.position(0);
  const Feedback f = b.cycle({.goal = DriveGoal::Enabled, .target = 2.001}, false);
  EXPECT_FALSE(f.fresh);
  EXPECT_EQ(f.state, DriveState::OperationEnabled);
  EXPECT_EQ(f.counts.value, 4000);
  EXPECT_EQ(b.target(), 4002);
}

TEST(Drive, counts_and_targets_pass_the_32_bit_wrap) {
  DriveBench b(2000);
  const std::int32_t top = std::numeric_limits<std::int32_t>::max();
  b.position(top - 1000);
  b.enable();
  b.cycle({.goal = DriveGoal::Enabled, .target = b.drive.commanded()});
  double mm = b.drive.commanded();
  for (int i = 0; i < 4000; ++i) {
    mm += 0.0005;  // one count
    b.cycle({.goal = DriveGoal::Enabled, .target = mm});
    b.position(b.target());
  }
  const Feedback f = b.cycle({.goal = DriveGoal::Enabled, .target = mm});
  EXPECT_EQ(f.fault, Fault::None);
  EXPECT_EQ(f.counts.value, std::int64_t{top} - 1000 + 4000);
  EXPECT_LT(b.target(), 0);
  EXPECT_NEAR(f.position, mm, 1e-6);
}

TEST(Drive, fault_reset_is_an_edge_whose_levels_each_outlast_lost_frames) {
  DriveBench b;
  b.status(0x0638);
  std::vector<int> bit7;  // as the drive sees it: only words of exchanges that came back
  for (int i = 0; i < 24; ++i) {
    const bool lost = i % 3 == 1;
    b.cycle({.goal = DriveGoal::FaultReset}, !lost);
    if (!lost) bit7.push_back((b.controlword() & 0x80) != 0);
    EXPECT_EQ(b.controlword() & 0x0F, 0);
  }
  int edges = 0, run = 1;
  for (std::size_t i = 1; i < bit7.size(); ++i) {
    if (bit7[i] == bit7[i - 1]) {
      ++run;
      continue;
    }
    edges += bit7[i];
    EXPECT_GE(run, 3);
    run = 1;
  }
  EXPECT_EQ(bit7.front(), 0);
  EXPECT_GE(edges, 1);
  b.status(0x0250);  // and when it has worked, nothing leads up again
  for (int i = 0; i < 10; ++i) {
    b.cycle({.goal = DriveGoal::FaultReset});
    EXPECT_EQ(b.controlword(), 0);
  }
}

TEST(Drive, faults_are_told_by_the_profiles_codes) {
  DriveBench b;
  b.enable();
  b.status(0x0238);
  b.layout.error_code.set(b.inputs, 0x3220);
  EXPECT_EQ(b.cycle({}).fault, Fault::Undervoltage);
  b.layout.error_code.set(b.inputs, 0x7777);
  EXPECT_EQ(b.cycle({}).fault, Fault::DriveFault);
  b.layout.error_code.set(b.inputs, 0);
  EXPECT_EQ(b.cycle({}).fault, Fault::DriveFaultNoCode);
  // Without the fault bit: an emergency input counts (R31), the code of a fault that is over does not.
  b.status(0x0250);
  b.layout.error_code.set(b.inputs, 0xFF23);
  EXPECT_EQ(b.cycle({}).fault, Fault::DriveEmergencyInput);
  b.layout.error_code.set(b.inputs, 0x3210);
  EXPECT_EQ(b.cycle({}).fault, Fault::None);
}

TEST(Drive, a_drive_that_does_not_answer_a_transition_is_told_after_a_second) {
  DriveBench b;
  int cycles = 0;
  while (b.cycle({.goal = DriveGoal::Enabled}).fault == Fault::None && cycles < 5000) ++cycles;
  EXPECT_EQ(b.drive.feedback().fault, Fault::TransitionTimeout);
  EXPECT_NEAR(cycles, 1000, 5);
}

/// Bit 0 of its statusword is never set: what is "ready to switch on" reads as "not ready" (xxxx xxxx x0xx 0000b),
/// where no transition is asked for, so that it drops to "switch-on disabled", and is led on from there, again and
/// again.
TEST(Drive, a_drive_that_goes_to_and_fro_between_two_states_is_told_after_a_second) {
  DriveBench b;
  int cycles = 0;
  while (b.cycle({.goal = DriveGoal::Enabled}).fault == Fault::None && cycles < 5000)
    b.status(++cycles / 4 % 2 == 0 ? 0x0250 : 0x0230 & ~0x0020);
  EXPECT_EQ(b.drive.feedback().fault, Fault::TransitionTimeout);
  EXPECT_NEAR(cycles, 1000, 10);
}

TEST(Drive, an_impossible_step_is_told_but_not_across_stale_cycles) {
  DriveBench b;
  b.cycle({.goal = DriveGoal::Enabled});
  b.status(0x1237);
  EXPECT_EQ(b.cycle({.goal = DriveGoal::Enabled}).fault, Fault::ImpossibleStatus);
  b.status(0x0250);
  b.cycle({.goal = DriveGoal::Enabled});
  b.cycle({.goal = DriveGoal::Enabled}, false);
  b.status(0x0233);
  EXPECT_EQ(b.cycle({.goal = DriveGoal::Enabled}).fault, Fault::None);
}

TEST(Drive, another_mode_than_asked_for_is_told_at_once_when_it_was_right_before) {
  DriveBench b;
  b.enable();
  for (int i = 0; i < 200; ++i) EXPECT_EQ(b.cycle({.goal = DriveGoal::Enabled}).fault, Fault::None);
  b.mode(1);
  EXPECT_EQ(b.cycle({.goal = DriveGoal::Enabled}).fault, Fault::WrongMode);
}

TEST(Drive, a_position_that_jumps_farther_than_the_axis_can_move_is_told) {
  DriveBench b(2000, false, {.step_max = 1.0});
  b.enable();
  b.position(1999);
  EXPECT_EQ(b.cycle({.goal = DriveGoal::Enabled}).fault, Fault::None);
  b.position(12'000);
  EXPECT_EQ(b.cycle({.goal = DriveGoal::Enabled}).fault, Fault::EncoderJump);
  b.cycle({.goal = DriveGoal::Enabled}, false);
  b.position(15'900);  // two cycles of travel
  EXPECT_EQ(b.cycle({.goal = DriveGoal::Enabled}).fault, Fault::None);
}

TEST(Drive, catching_up_after_lost_frames_is_no_jump_of_the_encoder) {
  DriveBench b(2000, false, {.step_max = 1.0});
  b.enable();
  constexpr std::int32_t kLost = 12;
  const DriveCommand there{.goal = DriveGoal::Enabled, .target = kLost};
  for (int i = 0; i < kLost; ++i) b.cycle(there, false);
  EXPECT_EQ(b.cycle(there).fault, Fault::None);  // latched before the new target came
  b.position(2000 * kLost);                      // the next inputs show all of it at once
  EXPECT_EQ(b.cycle(there).fault, Fault::None);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(b.cycle(there).fault, Fault::None);
  b.position(2000 * kLost + 2000 * 3);  // the allowance is over by now
  EXPECT_EQ(b.cycle(there).fault, Fault::EncoderJump);
}

TEST(Drive, catching_up_after_a_stall_is_no_jump_of_the_encoder) {
  DriveBench b(2000, false, {.step_max = 1.0});
  b.enable();
  constexpr std::int64_t kStalled = 21;
  const DriveCommand there{.goal = DriveGoal::Enabled, .target = kStalled};
  b.drive.read(b.inputs, true, kStalled);
  b.drive.write(b.outputs, there);    // the target goes on by 21 cycles of travel in this cycle's frame ...
  b.position(2000 * kStalled - 100);  // ... and the position follows in the next
  EXPECT_EQ(b.cycle(there).fault, Fault::None);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(b.cycle(there).fault, Fault::None);
  b.position(2000 * kStalled + 2000 * 3);  // the allowance is over by now
  EXPECT_EQ(b.cycle(there).fault, Fault::EncoderJump);
}

TEST(Drive, inputs_follow_the_bits_of_the_profile) {
  DriveBench b;
  b.layout.digital_inputs.set(b.inputs, 0x01E0'0005);
  const Feedback f = b.cycle({});
  EXPECT_TRUE(f.neg_limit);
  EXPECT_FALSE(f.pos_limit);
  EXPECT_TRUE(f.home);
}

TEST(Drive, an_inverted_axis_counts_down) {
  DriveBench b(2000, true);
  b.position(-3000);
  EXPECT_DOUBLE_EQ(b.cycle({}).position, 1.5);
  b.enable();
  b.cycle({.goal = DriveGoal::Enabled, .target = 2.0});
  EXPECT_EQ(b.target(), -4000);
}

}  // namespace
}  // namespace gantry::devices
