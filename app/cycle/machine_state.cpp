#include "app/cycle/machine_state.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace gantry::cycle {
namespace {

struct Change {
  State from;
  Cause cause;
  State to;
};

// A row whose `to` is its `from` says that the cause is taken there, and what it does leaves the state as it is.
constexpr std::array kChanges{
    Change{State::Offline, Cause::Operational, State::Disabled},
    Change{State::Offline, Cause::OperationalLatched, State::Stopped},
    Change{State::Offline, Cause::Abort, State::Offline},
    Change{State::Offline, Cause::Reset, State::Offline},

    Change{State::Disabled, Cause::Enable, State::Enabling},
    Change{State::Disabled, Cause::Disable, State::Disabled},
    Change{State::Disabled, Cause::Abort, State::Disabled},
    Change{State::Disabled, Cause::Reset, State::Disabled},
    Change{State::Disabled, Cause::PathStop, State::Stopped},
    Change{State::Disabled, Cause::AxisStop, State::Stopped},
    Change{State::Disabled, Cause::QuickStop, State::Stopped},
    Change{State::Disabled, Cause::Off, State::Stopped},

    Change{State::Enabling, Cause::TorqueOn, State::Ready},
    Change{State::Enabling, Cause::Disable, State::Disabling},
    Change{State::Enabling, Cause::Abort, State::Disabling},
    Change{State::Enabling, Cause::PathStop, State::Stopped},
    Change{State::Enabling, Cause::AxisStop, State::Stopped},
    Change{State::Enabling, Cause::QuickStop, State::Stopped},
    Change{State::Enabling, Cause::Off, State::Stopped},

    Change{State::Ready, Cause::Home, State::Homing},
    Change{State::Ready, Cause::Play, State::Running},
    Change{State::Ready, Cause::Disable, State::Disabling},
    Change{State::Ready, Cause::Abort, State::Ready},
    Change{State::Ready, Cause::Reset, State::Ready},
    Change{State::Ready, Cause::PathStop, State::Stopped},
    Change{State::Ready, Cause::AxisStop, State::Stopped},
    Change{State::Ready, Cause::QuickStop, State::Stopped},
    Change{State::Ready, Cause::Off, State::Stopped},

    Change{State::Disabling, Cause::TorqueOff, State::Disabled},
    Change{State::Disabling, Cause::Disable, State::Disabling},
    Change{State::Disabling, Cause::Abort, State::Disabling},
    Change{State::Disabling, Cause::PathStop, State::Stopped},
    Change{State::Disabling, Cause::AxisStop, State::Stopped},
    Change{State::Disabling, Cause::QuickStop, State::Stopped},
    Change{State::Disabling, Cause::Off, State::Stopped},

    // The drives home by themselves: whatever ends it, they brake, and the state waits for that.
    Change{State::Homing, Cause::Rest, State::Ready},
    Change{State::Homing, Cause::RestTorqueOff, State::Disabled},
    Change{State::Homing, Cause::RestLatched, State::Stopped},
    Change{State::Homing, Cause::Abort, State::Homing},
    Change{State::Homing, Cause::PathStop, State::Homing},
    Change{State::Homing, Cause::AxisStop, State::Homing},
    Change{State::Homing, Cause::QuickStop, State::Homing},
    Change{State::Homing, Cause::Off, State::Homing},

    Change{State::Running, Cause::BlockEnd, State::Ready},
    Change{State::Running, Cause::Hold, State::Holding},
    Change{State::Running, Cause::Abort, State::Stopping},
    Change{State::Running, Cause::PathStop, State::Stopping},
    Change{State::Running, Cause::AxisStop, State::Stopping},
    Change{State::Running, Cause::QuickStop, State::Stopping},
    Change{State::Running, Cause::Off, State::Stopping},

    Change{State::Holding, Cause::Rest, State::Held},
    Change{State::Holding, Cause::Hold, State::Holding},
    Change{State::Holding, Cause::Resume, State::Running},
    Change{State::Holding, Cause::Abort, State::Stopping},
    Change{State::Holding, Cause::PathStop, State::Stopping},
    Change{State::Holding, Cause::AxisStop, State::Stopping},
    Change{State::Holding, Cause::QuickStop, State::Stopping},
    Change{State::Holding, Cause::Off, State::Stopping},

    Change{State::Held, Cause::Hold, State::Held},
    Change{State::Held, Cause::Resume, State::Running},
    Change{State::Held, Cause::Abort, State::Stopping},
    Change{State::Held, Cause::Reset, State::Held},
    Change{State::Held, Cause::PathStop, State::Stopping},
    Change{State::Held, Cause::AxisStop, State::Stopping},
    Change{State::Held, Cause::QuickStop, State::Stopping},
    Change{State::Held, Cause::Off, State::Stopping},

    Change{State::Stopping, Cause::Rest, State::Ready},
    Change{State::Stopping, Cause::RestTorqueOff, State::Disabled},
    Change{State::Stopping, Cause::RestLatched, State::Stopped},
    Change{State::Stopping, Cause::Abort, State::Stopping},
    Change{State::Stopping, Cause::PathStop, State::Stopping},
    Change{State::Stopping, Cause::AxisStop, State::Stopping},
    Change{State::Stopping, Cause::QuickStop, State::Stopping},
    Change{State::Stopping, Cause::Off, State::Stopping},

    Change{State::Stopped, Cause::Cleared, State::Ready},
    Change{State::Stopped, Cause::ClearedTorqueOff, State::Disabled},
    Change{State::Stopped, Cause::Disable, State::Stopped},
    Change{State::Stopped, Cause::Abort, State::Stopped},
    Change{State::Stopped, Cause::Reset, State::Stopped},
    Change{State::Stopped, Cause::PathStop, State::Stopped},
    Change{State::Stopped, Cause::AxisStop, State::Stopped},
    Change{State::Stopped, Cause::QuickStop, State::Stopped},
    Change{State::Stopped, Cause::Off, State::Stopped},
};

constexpr std::array<StateRow, kStates> kRows{{
    {State::Offline, "offline", Lamp::Red, false, "the stations to come to OP"},
    {State::Disabled, "disabled", Lamp::Yellow, false, "`enable`"},
    {State::Enabling, "enabling", Lamp::Yellow, false, "the drives to have torque, or `abort`"},
    {State::Ready, "ready", Lamp::Green, false, "`run`, `jog`, `park` or `home`"},
    {State::Disabling, "disabling", Lamp::Yellow, false, "the drives to be without torque"},
    {State::Homing, "homing", Lamp::Green, true, "homing to end, or `abort`"},
    {State::Running, "running", Lamp::Green, true, "the motion to end, `hold` or `abort`"},
    {State::Holding, "holding", Lamp::Yellow, true, "the tool to stand, `resume` or `abort`"},
    {State::Held, "held", Lamp::Yellow, false, "`resume` or `abort`"},
    {State::Stopping, "stopping", Lamp::Red, true, "the axes to stand"},
    {State::Stopped, "stopped", Lamp::Red, false, "`reset`"},
}};

constexpr std::array<std::string_view, kCauses> kCauseNames{"enable",
                                                            "disable",
                                                            "home",
                                                            "play",
                                                            "hold",
                                                            "resume",
                                                            "abort",
                                                            "reset",
                                                            "all in OP",
                                                            "all in OP, a fault latched",
                                                            "torque on",
                                                            "torque off",
                                                            "block ended",
                                                            "at rest",
                                                            "at rest, torque lost",
                                                            "at rest, a fault latched",
                                                            "cleared",
                                                            "cleared, torque lost",
                                                            "path stop",
                                                            "axis-wise stop",
                                                            "quick stop",
                                                            "off"};

using devices::DriveGoal;
constexpr std::array kReactions{
    ReactionRow{Reaction::PathStop, Cause::PathStop, Braking::OnPath, std::nullopt},
    ReactionRow{Reaction::AxisStop, Cause::AxisStop, Braking::EachAxis, std::nullopt},
    ReactionRow{Reaction::QuickStop, Cause::QuickStop, Braking::EachAxis, DriveGoal::QuickStop},
    ReactionRow{Reaction::Off, Cause::Off, Braking::None, DriveGoal::Disabled},
};

/// The table by state and cause, so that a look-up costs nothing: 0 for none, else the state plus 1.
constexpr auto kNext = [] {
  std::array<std::array<std::uint8_t, kCauses>, kStates> table{};
  for (const Change& c : kChanges)
    table[static_cast<std::size_t>(c.from)][static_cast<std::size_t>(c.cause)] =
        static_cast<std::uint8_t>(static_cast<unsigned>(c.to) + 1);
  return table;
}();

}  // namespace

std::optional<State> next(State state, Cause cause) noexcept {
  const std::uint8_t found = kNext[static_cast<std::size_t>(state)][static_cast<std::size_t>(cause)];
  if (found == 0) return std::nullopt;
  return static_cast<State>(found - 1);
}

const StateRow& row(State state) noexcept { return kRows[static_cast<std::size_t>(state)]; }

std::string_view name(Cause cause) noexcept { return kCauseNames[static_cast<std::size_t>(cause)]; }

const ReactionRow* row(Reaction reaction) noexcept {
  const auto found =
      std::find_if(kReactions.begin(), kReactions.end(), [&](const ReactionRow& r) { return r.reaction == reaction; });
  return found == kReactions.end() ? nullptr : &*found;
}

}  // namespace gantry::cycle
