// The table of the machine's states, every pair of it, against rules that were written down apart from it.
#include "app/cycle/machine_state.hpp"

#include <deque>
#include <gtest/gtest.h>
#include <map>
#include <optional>
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
      EXPECT_NE(to, State::Held) << name(s) << ": a job that outlives it goes on by resume, from its next block";
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

/// The whole table once more, as what each cause means: where it is taken, and what it leads to. Nowhere else.
TEST(MachineState, every_pair_is_the_one_that_its_cause_means) {
  using S = State;
  using C = Cause;
  std::map<C, std::map<S, S>> meant{
      {C::Enable, {{S::Disabled, S::Enabling}}},
      {C::Disable,
       {{S::Disabled, S::Disabled},
        {S::Enabling, S::Disabling},
        {S::Ready, S::Disabling},
        {S::Disabling, S::Disabling},
        {S::Stopped, S::Stopped}}},
      {C::Home, {{S::Ready, S::Homing}}},
      {C::Play, {{S::Ready, S::Running}}},
      {C::Hold, {{S::Running, S::Holding}, {S::Holding, S::Holding}, {S::Held, S::Held}}},
      {C::Resume, {{S::Holding, S::Running}, {S::Held, S::Running}}},
      {C::Operational, {{S::Offline, S::Disabled}}},
      {C::OperationalLatched, {{S::Offline, S::Stopped}}},
      {C::TorqueOn, {{S::Enabling, S::Ready}}},
      {C::TorqueOff, {{S::Disabling, S::Disabled}}},
      {C::BlockEnd, {{S::Running, S::Ready}}},
      {C::Rest, {{S::Homing, S::Ready}, {S::Holding, S::Held}, {S::Stopping, S::Ready}}},
      {C::RestTorqueOff, {{S::Homing, S::Disabled}, {S::Stopping, S::Disabled}}},
      {C::RestLatched, {{S::Homing, S::Stopped}, {S::Stopping, S::Stopped}}},
      {C::Cleared, {{S::Stopped, S::Ready}}},
      {C::ClearedTorqueOff, {{S::Stopped, S::Disabled}}},
  };
  const std::set<S> plays{S::Running, S::Holding, S::Held}, torque_comes_or_goes{S::Enabling, S::Disabling};
  for (const S s : kAll) {
    const bool brakes = plays.contains(s) || s == S::Stopping;
    meant[C::Abort][s] = brakes ? S::Stopping : torque_comes_or_goes.contains(s) ? S::Disabling : s;
    if (!row(s).moves && !torque_comes_or_goes.contains(s)) meant[C::Reset][s] = s;
    for (const C fault : kFaults)  // drives that home brake by themselves, and no station answers offline
      if (s != S::Offline) meant[fault][s] = brakes ? S::Stopping : s == S::Homing ? S::Homing : S::Stopped;
  }
  for (const S s : kAll)
    for (std::size_t c = 0; c < kCauses; ++c) {
      const auto& of_cause = meant[cause_of(c)];
      const auto to = of_cause.find(s);
      EXPECT_EQ(next(s, cause_of(c)), to == of_cause.end() ? std::nullopt : std::optional(to->second))
          << name(s) << ", " << name(cause_of(c));
    }
}

TEST(MachineState, every_state_has_its_row) {
  for (const State s : kAll) {
    EXPECT_EQ(row(s).state, s);
    EXPECT_FALSE(row(s).name.empty());
    EXPECT_FALSE(row(s).left_by.empty()) << name(s);
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
