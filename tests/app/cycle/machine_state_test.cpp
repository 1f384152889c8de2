// The table of the machine's states, every pair of it, against rules that were written down apart from it.
#include "app/cycle/machine_state.hpp"

#include <deque>
#include <gtest/gtest.h>
#include <set>

namespace gantry::cycle {
namespace {

constexpr State kAll[] = {State::Offline,   State::Disabled, State::Enabling, State::Ready,
                          State::Disabling, State::Homing,   State::Running,  State::Holding,
                          State::Held,      State::Stopping, State::Stopped};
static_assert(std::size(kAll) == kStates);

Cause cause_of(std::size_t i) { return static_cast<Cause>(i); }
constexpr Cause kFaults[] = {Cause::PathStop, Cause::AxisStop, Cause::QuickStop, Cause::Off};

TEST(MachineState, an_abort_is_taken_everywhere_and_leads_to_no_motion) {
  for (const State s : kAll) {
    const auto to = next(s, Cause::Abort);
    ASSERT_TRUE(to) << name(s);
    EXPECT_NE(*to, State::Running) << name(s);
    EXPECT_NE(*to, State::Enabling) << name(s);
    EXPECT_TRUE(!row(*to).moves || row(s).moves || s == State::Held) << name(s) << ": only what moved still brakes";
  }
}

TEST(MachineState, only_orders_to_move_begin_motion) {
  for (const State s : kAll)
    for (std::size_t c = 0; c < kCauses; ++c) {
      const auto to = next(s, cause_of(c));
      if (!to || row(s).moves || !row(*to).moves) continue;
      const bool ordered = cause_of(c) == Cause::Play || cause_of(c) == Cause::Home || cause_of(c) == Cause::Resume;
      const bool brakes = s == State::Held && *to == State::Stopping;
      EXPECT_TRUE(ordered || brakes) << name(s) << ", " << name(cause_of(c)) << " -> " << name(*to);
    }
}

TEST(MachineState, a_reset_changes_no_state_and_is_refused_while_something_moves_or_is_under_way) {
  for (const State s : kAll) {
    const auto to = next(s, Cause::Reset);
    EXPECT_EQ(to.value_or(s), s) << name(s);
    EXPECT_EQ(to.has_value(), !row(s).moves && s != State::Enabling && s != State::Disabling) << name(s);
  }
}

TEST(MachineState, torque_comes_by_enable_alone) {
  for (const State s : kAll)
    for (std::size_t c = 0; c < kCauses; ++c)
      if (next(s, cause_of(c)) == State::Enabling) {
        EXPECT_EQ(s, State::Disabled);
        EXPECT_EQ(cause_of(c), Cause::Enable);
      }
}

TEST(MachineState, every_fault_ends_motion_and_none_starts_it) {
  for (const State s : kAll)
    for (const Cause fault : kFaults) {
      const State to = next(s, fault).value_or(s);
      EXPECT_NE(to, State::Ready) << name(s);
      EXPECT_NE(to, State::Running) << name(s);
      EXPECT_NE(to, State::Holding) << name(s);
      EXPECT_NE(to, State::Held) << name(s) << ": no job goes on after a fault yet";
      const bool plays = s == State::Running || s == State::Holding || s == State::Held;
      EXPECT_EQ(to == State::Stopping, plays || s == State::Stopping) << name(s);
    }
}

TEST(MachineState, motion_begins_from_ready_alone_and_goes_on_from_a_hold_alone) {
  for (const State s : kAll) {
    EXPECT_EQ(next(s, Cause::Play).has_value(), s == State::Ready) << name(s);
    EXPECT_EQ(next(s, Cause::Home).has_value(), s == State::Ready) << name(s);
    EXPECT_EQ(next(s, Cause::Resume).has_value(), s == State::Held || s == State::Holding) << name(s);
    EXPECT_EQ(next(s, Cause::Enable).has_value(), s == State::Disabled) << name(s);
  }
}

TEST(MachineState, what_is_latched_is_left_by_a_cleared_reset_alone) {
  for (std::size_t c = 0; c < kCauses; ++c) {
    const auto to = next(State::Stopped, cause_of(c));
    if (!to || *to == State::Stopped) continue;
    EXPECT_TRUE(cause_of(c) == Cause::Cleared || cause_of(c) == Cause::ClearedTorqueOff) << name(cause_of(c));
  }
}

/// By verbs alone, and by what then follows of itself, every state comes to ready.
TEST(MachineState, every_state_has_a_way_to_ready_by_verbs) {
  // What an operator can do, and what comes of itself when nothing is wrong any more.
  const std::set<Cause> usable = {Cause::Enable,
                                  Cause::Disable,
                                  Cause::Abort,
                                  Cause::Reset,
                                  Cause::Resume,
                                  Cause::Operational,
                                  Cause::OperationalLatched,
                                  Cause::TorqueOn,
                                  Cause::TorqueOff,
                                  Cause::BlockEnd,
                                  Cause::Rest,
                                  Cause::RestTorqueOff,
                                  Cause::RestLatched,
                                  Cause::Cleared,
                                  Cause::ClearedTorqueOff};
  for (const State from : kAll) {
    std::set<State> seen{from};
    std::deque<State> open{from};
    while (!open.empty()) {
      const State s = open.front();
      open.pop_front();
      for (const Cause c : usable)
        if (const auto to = next(s, c); to && seen.insert(*to).second) open.push_back(*to);
    }
    EXPECT_TRUE(seen.contains(State::Ready)) << name(from);
    EXPECT_TRUE(seen.contains(State::Disabled)) << name(from);
  }
}

TEST(MachineState, a_refusal_can_say_what_lifts_it) {
  for (const State s : kAll) {
    EXPECT_EQ(row(s).state, s);
    EXPECT_FALSE(row(s).name.empty());
    EXPECT_FALSE(row(s).lifts_it.empty()) << name(s);
  }
}

TEST(MachineState, every_reaction_but_a_note_has_its_row_and_rises) {
  EXPECT_EQ(row(Reaction::Note), nullptr);
  for (const Reaction r : {Reaction::PathStop, Reaction::AxisStop, Reaction::QuickStop, Reaction::Off}) {
    ASSERT_NE(row(r), nullptr);
    EXPECT_EQ(row(r)->goal.has_value(), r >= Reaction::QuickStop) << "path and axis-wise stops keep the torque";
  }
}

}  // namespace
}  // namespace gantry::cycle
