// THE fault catalogue: what can go wrong, what the machine then does, how it is cleared and what people are told. One
// table (fault_table.def) serves the RT loop, exit codes, `explain` and docs/faults.md.
//   const FaultInfo& f = info(Fault::FollowingError);   // f.reaction == Reaction::AxisStop
// Safe in the RT loop: plain constant data.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

namespace gantry {

/// What the machine does, by rising force (stop categories of IEC 60204-1, 9.2.2). The valve closes with every one but
/// Note.
enum class Reaction : std::uint8_t {
  Note,       ///< N: count, log, publish; motion goes on
  PathStop,   ///< P: brake on the path with the planner's limits; drives stay enabled; resumable
  AxisStop,   ///< A: every axis brakes with its own limit in parallel; position kept; the job ends
  QuickStop,  ///< Q: CiA 402 quick stop, standstill, brake, torque off; re-enable needed
  Off,        ///< O: disable voltage, valve off, at once
};

enum class Severity : std::uint8_t { Info, Warning, Error, Fatal };

/// How a latched fault is cleared. A latch never clears itself, and clearing it never starts motion.
enum class Clear : std::uint8_t {
  None,      ///< not latched: it ends with its message
  Reset,     ///< operator reset
  Resume,    ///< operator reset; a job that was stopped is then on hold, and waits for its resume
  Reenable,  ///< reset, then enable the drives again
  Rehome,    ///< reset, enable, and the axis must be referenced again
  Restart,   ///< the program must be started again
};

/// What an event's `detail` is: its unit.
enum class Detail : std::uint8_t {
  None,
  Distance,  ///< um; mrad on a rotary axis
  Target,    ///< the same, from the position to what was asked for, which is the event's value
  Cycles,
  LateCycles,  ///< so many in the late window (app/cycle/loop_setup.hpp)
  Frames,
  Nanoseconds,
  Microseconds,
  Milliseconds,
  AlStates,  ///< OR of all stations' AL states
  WorkingCounter,
  Statusword,     ///< 6041h
  DriveCode,      ///< 603Fh; the drive's own text
  EmergencyCode,  ///< of the emergency message
};

enum class ExitCode : int {
  Done = 0,
  Internal = 1,
  Usage = 2,
  InvalidFile = 3,
  NotFeasible = 4,
  Device = 5,
  VisionOrProbe = 6,
  Refused = 7,
  Deadline = 8,
  DoneWithDefects = 9,  ///< of a job that came to its end, and of no fault
  Interrupted = 130,
};

enum class Fault : std::uint16_t {
#define GANTRY_FAULT(number, name, ...) name = number,
#include "core/fault_table.def"
#undef GANTRY_FAULT
};

struct FaultInfo {
  Fault fault;
  std::string_view name;
  std::string_view
      threat;  ///< row of the threat catalogue (docs/threats.md), "R30"; empty for mistakes in files and usage
  Severity severity;
  Reaction reaction;
  Clear clear;
  ExitCode exit_code;
  Detail detail;
  std::string_view text;    ///< what happened
  std::string_view remedy;  ///< what to do
};

/// The row of a fault. A number that is not in the catalogue yields the row of Fault::Internal.
const FaultInfo& info(Fault fault) noexcept;

/// All rows, ascending by number.
std::span<const FaultInfo> catalogue() noexcept;

/// "G204": the form in which people meet the number.
struct FaultCode {
  char text[8];
  operator std::string_view() const noexcept { return text; }
};
FaultCode code(Fault fault) noexcept;

constexpr bool latches(const FaultInfo& f) noexcept { return f.clear != Clear::None; }
/// A job that it stops can go on.
constexpr bool outlived(const FaultInfo& f) noexcept { return f.clear == Clear::Resume; }

}  // namespace gantry
