// The guard against the methods of IEC 61800-7-201 (10.4), told here as what each of them looks for and turns round at.
#include "devices/rt/homing_guard.hpp"

#include <gtest/gtest.h>

namespace gantry::devices {
namespace {

constexpr std::uint8_t kAll = kSwitchNeg | kSwitchPos | kSwitchHome;

Feedback at(std::int64_t counts, std::uint8_t switches) {
  Feedback f;
  f.fresh = true;
  f.counts = {counts};
  f.neg_limit = (switches & kSwitchNeg) != 0;
  f.pos_limit = (switches & kSwitchPos) != 0;
  f.home = (switches & kSwitchHome) != 0;
  return f;
}
HomingRules rules(int method, double counts_per_cycle = 0) {
  HomingRules r = homing_rules(method);
  r.known = kAll;
  r.counts_per_cycle = counts_per_cycle;
  return r;
}
Fault after(HomingGuard& guard, int cycles, std::uint8_t switches) {
  Fault found = Fault::None;
  for (int i = 0; i < cycles && found == Fault::None; ++i) found = guard.look(at(0, switches));
  return found;
}

TEST(HomingGuard, a_limit_that_its_method_comes_to_is_met_and_the_other_one_ends_it) {
  struct Method {
    int method;
    bool neg, pos;  ///< met by it
  };
  for (const Method& m : {Method{17, true, false},
                          {18, false, true},
                          {19, false, false},
                          {20, false, false},
                          {21, false, false},
                          {22, false, false},
                          {23, false, true},
                          {24, false, true},
                          {25, false, true},
                          {26, false, true},
                          {27, true, false},
                          {28, true, false},
                          {29, true, false},
                          {30, true, false},
                          {35, false, false}}) {
    HomingGuard neg(rules(m.method), at(0, 0)), pos(rules(m.method), at(0, 0)), both(rules(m.method), at(0, 0));
    EXPECT_EQ(after(neg, 100, kSwitchNeg) == Fault::None, m.neg) << m.method;
    EXPECT_EQ(after(pos, 100, kSwitchPos) == Fault::None, m.pos) << m.method;
    EXPECT_EQ(after(both, 100, kSwitchNeg | kSwitchPos), Fault::HomingWrongLimit) << m.method;
  }
}

TEST(HomingGuard, an_input_that_flickers_is_no_limit) {
  HomingGuard guard(rules(17), at(0, 0));
  for (int i = 0; i < 3000; ++i) ASSERT_EQ(guard.look(at(0, i % 3 == 0 ? 0 : kSwitchPos)), Fault::None);
}

/// At a machine's cycle of 0.25 ms a contact bounces for many cycles.
TEST(HomingGuard, so_many_cycles_as_the_rules_say_are_a_flicker) {
  HomingRules r = rules(17);
  r.flickers_cycles = 12;
  HomingGuard guard(r, at(0, 0));
  for (int i = 0; i < 3000; ++i) ASSERT_EQ(guard.look(at(0, i % 12 == 0 ? 0 : kSwitchPos)), Fault::None);
  EXPECT_EQ(after(guard, 12, kSwitchPos), Fault::HomingWrongLimit);
}

TEST(HomingGuard, the_wrong_limit_may_be_left_and_not_met_again) {
  HomingGuard guard(rules(17), at(0, kSwitchPos));
  EXPECT_EQ(after(guard, 500, kSwitchPos), Fault::None);
  EXPECT_EQ(after(guard, 500, 0), Fault::None);
  EXPECT_EQ(after(guard, 500, kSwitchPos), Fault::HomingWrongLimit);
}

/// A limit lies at the end of its direction: an axis that stands on it gets off it by going the other way.
TEST(HomingGuard, a_limit_that_opens_as_the_axis_goes_on_towards_it_is_the_other_one) {
  for (const int method : {17, 18, 21, 35}) {
    const auto leave = [&](std::uint8_t on, int step) {
      HomingGuard guard(rules(method, 60), at(-3000, on));
      Fault found = Fault::None;
      for (int i = 1; i < 400 && found == Fault::None; ++i)
        found = guard.look(at(-3000 + std::int64_t{step} * i, i < 200 ? on : 0));
      return found;
    };
    EXPECT_EQ(leave(kSwitchNeg, 5), Fault::None) << method;
    EXPECT_EQ(leave(kSwitchPos, -5), Fault::None) << method;
    EXPECT_EQ(leave(kSwitchNeg, -5), Fault::HomingWrongLimit) << method;
    EXPECT_EQ(leave(kSwitchPos, 5), Fault::HomingWrongLimit) << method;
    EXPECT_EQ(leave(kSwitchPos, 0), Fault::None) << method << ": a contact that opens where it stands shows nothing";
    EXPECT_EQ(leave(kSwitchPos, 3), Fault::None) << method << ": within what a counter may be set by";
  }
}

/// 18 and 17 home at a limit: an axis that stands on it goes off it, and no farther than the bound while it is closed.
TEST(HomingGuard, a_reference_limit_that_stays_closed_ends_it_by_travel_or_by_time) {
  HomingRules r = rules(17, 60);
  r.leave_counts = 20'000, r.leave_cycles = 9000;
  const auto leave = [&](double speed, std::int64_t opens_at, std::int64_t set_at) {
    HomingGuard guard(r, at(0, kSwitchNeg));
    for (int i = 1; i <= 20'000; ++i) {
      const auto moved = static_cast<std::int64_t>(speed * i);
      const std::int64_t shown = moved < set_at ? moved : moved + 400'000;  // the counter is set anew there
      const Fault found = guard.look(at(shown, moved < opens_at ? kSwitchNeg : 0));
      if (found != Fault::None) return std::pair{found, moved};
    }
    return std::pair{Fault::None, std::int64_t{0}};
  };
  constexpr std::int64_t kNever = 100'000'000;
  EXPECT_EQ(leave(5, kNever, kNever), (std::pair{Fault::HomingSwitchStuck, std::int64_t{20'005}}));
  EXPECT_EQ(leave(5, 19'000, kNever).first, Fault::None);
  EXPECT_EQ(leave(5, 19'000, 18'000).first, Fault::None) << "a counter that is set is no travel";
  EXPECT_EQ(leave(0, kNever, kNever).first, Fault::HomingSwitchStuck) << "it presses into its stop";
  r.known = kSwitchHome;
  EXPECT_EQ(leave(5, kNever, kNever).first, Fault::None) << "a limit that is not shown says nothing";
  r = rules(21, 60), r.leave_counts = 20'000, r.leave_cycles = 9000;
  HomingGuard home(r, at(0, kSwitchHome));
  for (int i = 1; i < 20'000; ++i) ASSERT_EQ(home.look(at(5 * i, kSwitchHome)), Fault::None) << "a cam may be long";
  r.leaves |= kSwitchHome;
  HomingGuard outside(r, at(0, kSwitchHome));
  int i = 1;
  while (i < 20'000 && outside.look(at(5 * i, kSwitchHome)) == Fault::None) ++i;
  EXPECT_EQ(i, 4001) << "not one that stands beyond the travel";
}

TEST(HomingGuard, done_without_its_switch_is_not_found) {
  HomingGuard guard(rules(17), at(0, 0));
  after(guard, 10, 0);
  EXPECT_FALSE(guard.found_switch());
  after(guard, 1, kSwitchNeg);
  EXPECT_TRUE(guard.found_switch());
  HomingRules blind = rules(17);
  blind.known = kSwitchHome;  // this drive shows no limits
  EXPECT_TRUE(HomingGuard(blind, at(0, 0)).found_switch());
  EXPECT_TRUE(HomingGuard(rules(35), at(0, 0)).found_switch());
}

TEST(HomingGuard, inputs_that_are_not_seen_end_it_unless_the_machine_file_accepts_a_drive_without_them) {
  const auto unseen = [](InputSource source) {
    Feedback f = at(0, 0);
    f.inputs = source;
    return f;
  };
  for (const InputSource source : {InputSource::Silent, InputSource::Absent}) {
    HomingGuard guard(rules(17), unseen(source));
    EXPECT_EQ(guard.look(unseen(source)), Fault::SwitchesUnseen);
  }
  HomingGuard polled(rules(17), unseen(InputSource::Polled));
  EXPECT_EQ(polled.look(unseen(InputSource::Polled)), Fault::None);
  EXPECT_EQ(polled.look(unseen(InputSource::Silent)), Fault::SwitchesUnseen) << "it fell silent";
  HomingRules accepted = rules(17);
  accepted.unseen_accepted = true;
  HomingGuard absent(accepted, unseen(InputSource::Absent));
  EXPECT_EQ(absent.look(unseen(InputSource::Absent)), Fault::None);
  EXPECT_TRUE(absent.found_switch()) << "the drive alone knows";
  HomingGuard silent(accepted, unseen(InputSource::Silent));
  EXPECT_EQ(silent.look(unseen(InputSource::Silent)), Fault::SwitchesUnseen) << "one that shows them has to answer";
}

TEST(HomingGuard, twice_the_speed_ends_it_and_a_tenth_more_does_not) {
  for (const auto& [speed, fault] :
       {std::pair{60, Fault::None}, {66, Fault::None}, {120, Fault::HomingTooFast}, {10'000, Fault::HomingTooFast}}) {
    HomingGuard guard(rules(17, 60), at(0, 0));
    Fault found = Fault::None;
    for (int i = 1; i <= 200 && found == Fault::None; ++i) found = guard.look(at(-speed * i, 0));
    EXPECT_EQ(found, fault) << speed;
  }
}

TEST(HomingGuard, cycles_that_were_skipped_are_no_speed) {
  HomingGuard guard(rules(17, 60), at(0, 0));
  std::int64_t counts = 0;
  for (int i = 0; i < 500; ++i) {
    const int elapsed = i % 7 == 0 ? 12 : 1 + i % 3;
    counts -= 60 * elapsed;
    ASSERT_EQ(guard.look(at(counts, 0), elapsed), Fault::None) << i;
  }
}

// The host takes the processor between waking up and sending: the frame comes late, or the next one is the first that
// is heard, and shows what was travelled in all that time; the cycles are counted when the loop wakes up again.
// Wherever that lies in the guard's windows.
TEST(HomingGuard, a_frame_that_was_held_up_is_no_speed) {
  for (const int unheard : {0, 1, 2, 4})
    for (int every = 11; every < 60; ++every)
      for (const int late : {3, 6, 9, 15, 30}) {
        HomingGuard guard(rules(17, 60), at(0, 0));
        std::int64_t counts = 0;
        for (int i = 1; i < 2000; ++i) {
          const bool held_up = i % every == 0;
          counts -= 60 * (held_up ? 1 + unheard + late : 1);
          ASSERT_EQ(guard.look(at(counts, 0), held_up ? 1 + unheard : 1), Fault::None)
              << i << ", " << late << " in " << every << ", unheard " << unheard;
          if (!held_up) continue;
          counts -= 60;
          ASSERT_EQ(guard.look(at(counts, 0), 1 + late), Fault::None);
        }
      }
}

TEST(HomingGuard, a_counter_that_is_set_at_the_edge_is_no_speed) {
  for (const int before : {400'000, 40'000, 9'000, 5'000, 900, 500, 60, 0, -300, -3'000}) {
    HomingGuard guard(rules(17, 60), at(before + 60 * 100, 0));
    for (int i = 100; i > 0; --i) ASSERT_EQ(guard.look(at(before + 60 * i, 0)), Fault::None) << before;
    for (int i = 0; i < 100; ++i) ASSERT_EQ(guard.look(at(5 * i, kSwitchNeg)), Fault::None) << before;
  }
}

}  // namespace
}  // namespace gantry::devices
