// What the machine as a whole is doing, and what changes it: one table of state and cause. The loop carries it out,
// docs/states.md prints it, and whoever gives an order looks here whether it is taken.
//   if (const auto to = next(state, Cause::Hold)) enter(*to);      // nothing: this cause changes nothing here
// An order (Enable ... Reset) that has no row in a state is refused there (in words: app/run/refusal.hpp).
// RT: pure functions over constant tables.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/fault.hpp"
#include "devices/rt/cia402.hpp"

namespace gantry::cycle {

enum class State : std::uint8_t {
  Offline,    ///< the bus is not in OP
  Disabled,   ///< in OP, drives without torque
  Enabling,   ///< drives on their way to Operation Enabled
  Ready,      ///< enabled, standing
  Disabling,  ///< drives on their way down, in order
  Homing,
  Running,   ///< a block plays
  Holding,   ///< on the way to a standstill on the path, resumable
  Held,      ///< standing on the path, resumable
  Stopping,  ///< braking because of a fault or an abort; the block is lost
  Stopped,   ///< a fault is latched, nothing is commanded to move
};
inline constexpr std::size_t kStates = 11;

enum class Cause : std::uint8_t {
  // orders
  Enable,
  Disable,
  Home,
  Play,
  Hold,
  Resume,
  Abort,
  Reset,
  // what bus and drives have come to
  Operational,  ///< all stations in OP, nothing latched
  OperationalLatched,
  TorqueOn,   ///< every drive of a streamed axis takes targets
  TorqueOff,  ///< no drive has torque
  // motion has come to its end
  BlockEnd,       ///< the block was played whole
  Rest,           ///< no motion is commanded any more: with torque, and nothing latched
  RestTorqueOff,  ///< the same, and a drive has lost its torque
  RestLatched,    ///< the same, and a fault is latched
  // a reset has found every cause gone
  Cleared,
  ClearedTorqueOff,
  // faults, by what the machine does about them
  PathStop,
  AxisStop,
  QuickStop,
  Off,
};
inline constexpr std::size_t kCauses = 22;

constexpr bool is_order(Cause cause) noexcept { return cause <= Cause::Reset; }

/// The state that follows; nothing where the cause changes nothing, and where an order is refused.
std::optional<State> next(State state, Cause cause) noexcept;

/// Of the stack light.
enum class Lamp : std::uint8_t { Red, Yellow, Green };
inline constexpr std::size_t kLamps = 3;

struct StateRow {
  State state;
  std::string_view name;
  Lamp lamp;
  bool moves;                ///< a motion is commanded
  std::string_view left_by;  ///< what takes the machine out of it
};
const StateRow& row(State state) noexcept;
inline const char* name(State state) noexcept { return row(state).name.data(); }
std::string_view name(Cause cause) noexcept;

/// How the axes come to rest.
enum class Braking : std::uint8_t {
  None,      ///< they do not: torque goes at once
  OnPath,    ///< all together, on the path
  EachAxis,  ///< each with its own limits, off the path
};

/// What the machine does about a fault. The valve closes with every one.
struct ReactionRow {
  Reaction reaction;
  Cause cause;
  Braking braking;
  std::optional<devices::DriveGoal> goal;  ///< what the drives are then asked for; nothing: they keep their torque
};
/// Nothing for Reaction::Note: motion goes on.
const ReactionRow* row(Reaction reaction) noexcept;

}  // namespace gantry::cycle
