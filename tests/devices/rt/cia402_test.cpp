#include "devices/rt/cia402.hpp"

#include <gtest/gtest.h>
#include <random>

namespace gantry::devices {
namespace {

using enum DriveState;

struct Printed {
  std::uint16_t statusword;
  DriveState state;
  const char* where;
};

// Every statusword that the manuals print for a state, in every mode.
constexpr Printed kPrinted[] = {
    // iD286-ECFA V2.2, 10.1, typical values: CSP, PP, PV, HM
    {0x0250, SwitchOnDisabled, "iD286 00h"},
    {0x0231, ReadyToSwitchOn, "iD286 06h"},
    {0x0233, SwitchedOn, "iD286 07h"},
    {0x1237, OperationEnabled, "iD286 CSP 0Fh, run, change, stop"},
    {0x8237, OperationEnabled, "iD286 PP 0Fh"},
    {0x1637, OperationEnabled, "iD286 PV; PP change"},
    {0x8337, OperationEnabled, "iD286 HM 0Fh"},
    {0x0237, OperationEnabled, "iD286 HM 1Fh"},
    {0x1737, OperationEnabled, "iD286 PP, PV 10Fh"},
    {0x0737, OperationEnabled, "iD286 HM 10Fh"},
    {0x0238, Fault, "iD286 CSP, HM fault"},
    {0x1238, Fault, "iD286 PP fault"},
    {0x1638, Fault, "iD286 PV fault"},
    // AMD530B 6.2, transition values
    {0x0000, NotReady, "AMD530B power-up"},
    {0x0217, QuickStopActive, "AMD530B 02h"},
    {0x021F, FaultReaction, "AMD530B fault reaction"},
    {0x0218, Fault, "AMD530B fault"},
    // AMD530B 6.2, mode table
    {0x0650, SwitchOnDisabled, "AMD530B PP, PV init"},
    {0x0670, SwitchOnDisabled, "AMD530B HM init"},
    {0x0631, ReadyToSwitchOn, "AMD530B 06h"},
    {0x0633, SwitchedOn, "AMD530B 07h"},
    {0x8637, OperationEnabled, "AMD530B PP enable"},
    {0x8737, OperationEnabled, "AMD530B HM enable"},
    {0x2637, OperationEnabled, "AMD530B HM error"},
    {0x0638, Fault, "AMD530B fault, idle"},
    // ISS 3: patterns 0XX1000 for a fault; bit 9 is "running" there and 0 at standstill
    {0x0008, Fault, "ISS"},
    {0x0037, OperationEnabled, "ISS at standstill"},
};

TEST(Cia402, decodes_every_statusword_that_the_manuals_print) {
  for (const auto& p : kPrinted) EXPECT_EQ(decode(p.statusword), p.state) << p.where << std::hex << " " << p.statusword;
}

TEST(Cia402, bits_that_vary_with_mode_and_vendor_do_not_change_the_state) {
  for (const auto& p : kPrinted)
    for (unsigned varying = 0; varying < 512; ++varying) {  // bits 4, 7, 8-15 in some combination
      const auto word = static_cast<std::uint16_t>((p.statusword & 0x006F) | (varying & 1) << 4 | (varying & 2) << 6 |
                                                   (varying & 0x1FC) << 7);
      EXPECT_EQ(decode(word), decode(static_cast<std::uint16_t>(p.statusword & 0x006F)));
    }
}

TEST(Cia402, the_way_up_is_06_07_0F_and_every_word_is_the_one_that_the_manuals_name) {
  EXPECT_EQ(next_controlword(SwitchOnDisabled, DriveGoal::Enabled, 0), 0x06);
  EXPECT_EQ(next_controlword(ReadyToSwitchOn, DriveGoal::Enabled, 0x06), 0x07);
  EXPECT_EQ(next_controlword(SwitchedOn, DriveGoal::Enabled, 0x07), 0x0F);
  EXPECT_EQ(next_controlword(OperationEnabled, DriveGoal::Enabled, 0x0F), 0x0F);
  EXPECT_EQ(next_controlword(OperationEnabled, DriveGoal::QuickStop, 0x0F), 0x02);
  EXPECT_EQ(next_controlword(QuickStopActive, DriveGoal::QuickStop, 0x02), 0x02);
  EXPECT_EQ(next_controlword(OperationEnabled, DriveGoal::SwitchedOn, 0x0F), 0x07);
  EXPECT_EQ(next_controlword(OperationEnabled, DriveGoal::Ready, 0x0F), 0x06);
  EXPECT_EQ(next_controlword(OperationEnabled, DriveGoal::Disabled, 0x0F), 0x00);
  // AMD530B with 605Ah 5..7 cannot enable until the controlword was switched back: the way out of quick stop is 00h.
  EXPECT_EQ(next_controlword(QuickStopActive, DriveGoal::Enabled, 0x02), 0x00);
}

TEST(Cia402, a_fault_is_left_by_a_rising_edge_of_bit_7_and_by_no_other_goal) {
  EXPECT_EQ(next_controlword(Fault, DriveGoal::FaultReset, 0x0F), 0x80);
  EXPECT_EQ(next_controlword(Fault, DriveGoal::FaultReset, 0x80), 0x00);
  for (const auto goal :
       {DriveGoal::Disabled, DriveGoal::Ready, DriveGoal::SwitchedOn, DriveGoal::Enabled, DriveGoal::QuickStop})
    EXPECT_EQ(next_controlword(Fault, goal, 0) & 0x80, 0);
}

// A model of figure 4 of IEC 61800-7-201: what a controlword makes of a state. Every goal is reached from every state,
// except that a fault is left by FaultReset alone.
DriveState drive_model(DriveState s, std::uint16_t word, std::uint16_t last) {
  const bool reset = (word & 0x80) != 0 && (last & 0x80) == 0;
  if (s == Fault) return reset ? SwitchOnDisabled : Fault;
  if (s == FaultReaction) return Fault;
  if (s == NotReady) return SwitchOnDisabled;
  if ((word & 0x02) == 0) return SwitchOnDisabled;  // disable voltage
  if ((word & 0x04) == 0) return s == OperationEnabled || s == QuickStopActive ? QuickStopActive : SwitchOnDisabled;
  if ((word & 0x01) == 0) return s == QuickStopActive ? s : ReadyToSwitchOn;                      // shutdown
  if ((word & 0x08) == 0) return s == ReadyToSwitchOn || s == OperationEnabled ? SwitchedOn : s;  // switch on
  return s == SwitchedOn || s == OperationEnabled ? OperationEnabled : s;                         // enable operation
}

TEST(Cia402, every_goal_is_reached_from_every_state_of_the_standards_machine) {
  for (const auto goal : {DriveGoal::Disabled, DriveGoal::Ready, DriveGoal::SwitchedOn, DriveGoal::Enabled,
                          DriveGoal::QuickStop, DriveGoal::FaultReset})
    for (const auto from : {NotReady, SwitchOnDisabled, ReadyToSwitchOn, SwitchedOn, OperationEnabled, QuickStopActive,
                            FaultReaction, Fault}) {
      DriveState s = from;
      std::uint16_t word = 0x80;  // the worst beginning for an edge
      for (int i = 0; i < 8; ++i) {
        const std::uint16_t next = next_controlword(s, goal, word);
        const DriveState after = drive_model(s, next, word);
        EXPECT_TRUE(may_follow(s, after)) << name(s) << " -> " << name(after);
        s = after;
        word = next;
      }
      const bool stays_in_fault = (from == Fault || from == FaultReaction) && goal != DriveGoal::FaultReset;
      EXPECT_TRUE(stays_in_fault ? s == Fault : reached(s, goal)) << name(from) << " goal " << static_cast<int>(goal);
    }
}

TEST(Cia402, steps_that_the_standard_does_not_know_are_told) {
  EXPECT_FALSE(may_follow(SwitchOnDisabled, OperationEnabled));
  EXPECT_FALSE(may_follow(ReadyToSwitchOn, OperationEnabled));
  EXPECT_FALSE(may_follow(Fault, OperationEnabled));
  EXPECT_FALSE(may_follow(Fault, ReadyToSwitchOn));
  EXPECT_FALSE(may_follow(SwitchedOn, QuickStopActive));
  EXPECT_FALSE(may_follow(OperationEnabled, Unknown));
  for (const auto from : {SwitchOnDisabled, ReadyToSwitchOn, SwitchedOn, OperationEnabled, QuickStopActive}) {
    EXPECT_TRUE(may_follow(from, Fault));
    EXPECT_TRUE(may_follow(from, FaultReaction));
    EXPECT_TRUE(may_follow(from, SwitchOnDisabled));
  }
}

// R41: whatever a drive says, torque is never asked for beyond the next step, and motion never but when it is enabled.
TEST(Cia402, random_statuswords_never_make_it_command_more_than_the_next_step) {
  const unsigned seed = 402;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uint16_t last = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const auto word = static_cast<std::uint16_t>(random());
    const auto goal = static_cast<DriveGoal>(random() % 6);
    const DriveState s = decode(word);
    const std::uint16_t out = next_controlword(s, goal, last);
    const bool enable = (out & 0x0F) == 0x0F;
    ASSERT_TRUE(!enable || (goal == DriveGoal::Enabled && (s == SwitchedOn || s == OperationEnabled)));
    ASSERT_TRUE((out & 0x80) == 0 || (goal == DriveGoal::FaultReset && s == Fault && (out & 0x0F) == 0));
    last = out;
  }
}

}  // namespace
}  // namespace gantry::devices
