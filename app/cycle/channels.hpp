// The whole boundary between the 1 ms loop and everything else: rings of plain values and one flag. The run thread is
// the only producer of commands and segments, the feed (app/run/feed.hpp) the only reader of snapshots and events.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "app/cycle/machine_state.hpp"
#include "core/axis_vec.hpp"
#include "core/fault.hpp"
#include "core/id.hpp"
#include "core/rt/ring.hpp"
#include "motion/types.hpp"

namespace gantry::cycle {

inline constexpr StationId kNoStation{0xFFFF};

enum class CommandKind : std::uint8_t {
  Enable,      ///< all drives to Operation Enabled
  Disable,     ///< all drives down in order
  Home,        ///< the axes of `axes`, together
  ArmProbe,    ///< the probe must be armed before a block that touches
  StartBlock,  ///< play the segments of block `block`, which are in the ring
  Hold,        ///< stop on the path, as soon as the valve has shut as planned; `value` = 1, or a second one: now
  Resume,
  Abort,       ///< stop on the path, drop the rest of the block
  Override,    ///< `value` = 1 for 100 %
  SetOutputs,  ///< `mask`, `bits` of the output word; never the valve
  Reset,       ///< clear latches whose cause is gone; nothing moves
};
/// As a row of the machine's states; nothing: not bound to a state (override, outputs).
std::optional<Cause> cause(CommandKind kind) noexcept;

/// What a block is for. A job works on a board, so that it asks for a closed clamp. A jog stands in time at the speed
/// it was planned with, so that no override makes it faster. In setup only a slow jog and a walk play. A slow jog that
/// was begun there goes on in automatic, as slowly, where the door is shut. A walk moves an axis so little that it may
/// be without a reference (LoopSetup::walk_max), and plays in setup only.
enum class Purpose : std::uint8_t { Job, Park, Jog, SlowJog, Walk };
/// It may move the machine while its door is open.
constexpr bool plays_in_setup(Purpose purpose) noexcept {
  return purpose == Purpose::SlowJog || purpose == Purpose::Walk;
}
/// At no more than the speed that it was planned with, whatever the override.
constexpr bool keeps_planned_speed(Purpose purpose) noexcept {
  return purpose == Purpose::Jog || plays_in_setup(purpose);
}

struct Command {
  CommandKind kind{};
  std::uint32_t id = 0;    ///< comes back in Event::CommandDone
  std::uint32_t axes = 0;  ///< bit n: AxisId n
  std::uint32_t block = 0;
  std::uint32_t mask = 0, bits = 0;
  double value = 0;
  Purpose purpose = Purpose::Job;  ///< StartBlock
};

enum class EventKind : std::uint8_t {
  CommandDone,  ///< `id`; `fault` None, or why it was refused or failed
  BlockDone,    ///< `block` is over and the axes stand; `fault` None: it came to its end, else what stopped it
  Touched,      ///< the probe latched: `axis`, `value` = coordinate in mm
  Fault,        ///< `fault`, `axis`, `station`, `detail` in the unit of its row (core/fault_table.def)
  StateChange,  ///< `detail` = new State
};

struct Event {
  EventKind kind{};
  Fault fault = Fault::None;
  AxisId axis = kNoAxis;
  StationId station = kNoStation;
  std::uint32_t id = 0, block = 0;
  std::int32_t detail = 0;
  double value = 0;
  CycleIndex cycle = 0;
};

inline constexpr std::size_t kMaxDrives = 16;
inline constexpr std::size_t kMaxStations = 64;

/// Everything one cycle knows. Pushed every cycle; cycles that a stall skipped are pushed too, with `sent` false, as
/// far as the loop makes up for them (200 at most), so that the commanded stream has no holes.
struct Snapshot {
  CycleIndex cycle = 0;
  std::int64_t time_ns = 0;     ///< when the cycle was due, machine clock
  std::int32_t wake_ns = 0;     ///< how late the loop woke
  std::int32_t compute_ns = 0;  ///< own work of the cycle, without the bus
  std::int32_t bus_ns = 0;      ///< exchange: send until the answer was read
  bool in_time = false;         ///< the cycles keep their distance from the bus's clock; also where it has none
  State state = State::Offline;
  bool sent = true;
  bool answered = true;  ///< every frame of the cycle came back, whoever took part
  bool inputs_fresh = false;
  bool complete = false;        ///< as many stations took part as belong to the bus
  bool operational = false;     ///< every station says that it is operational
  Fault latched = Fault::None;  ///< first fault that is latched
  std::uint32_t block = 0;      ///< 0: idle
  std::uint32_t tick = 0;       ///< tick in the block, from 1
  std::uint32_t feature = motion::kTravel;
  bool valve_cut = false;  ///< a stop has shut the valve in this cycle, which was open in the last
  std::uint32_t outputs = 0, inputs = 0;
  std::uint16_t working_counter = 0, expected = 0;  ///< these three are EtherCAT's, and for people
  std::uint16_t al_states = 0;
  std::uint8_t axes = 0, drives = 0;
  std::uint32_t enabled = 0;  ///< bit n: AxisId n has torque
  std::uint32_t referenced = 0;
  double override_factor = 1;
  double path_speed = 0;
  double along_block_mm = 0;  ///< length of path from the block's start, as planned: the drives are there later by the
                              ///< largest response delay
  AxisVec target{};           ///< mm or rad, as sent
  AxisVec actual{};
  AxisVec following{};                            ///< target - actual of the same cycle; NaN on open-loop axes
  std::array<std::int32_t, kMaxDrives> counts{};  ///< 607Ah as sent, drive by drive in the machine file's order
  std::array<std::uint16_t, kMaxDrives> statusword{};
  std::array<std::uint16_t, kMaxDrives> error_code{};  ///< 603Fh
};

struct Channels {
  rt::Ring<Command, 64> commands;
  rt::Ring<motion::Segment, 1024> segments;
  rt::Ring<Snapshot, 4096> snapshots;
  rt::Ring<Event, 256> events;
  /// An abort from any thread: a path stop at the next tick. As long as it is set, nothing begins to move.
  std::atomic<bool> stop_now{false};
  std::atomic<bool> on_hold{false};    ///< whoever gives the blocks waits for a resume before the next one
  std::atomic<bool> quit{false};       ///< the loop returns after the running tick
  std::atomic<std::uint64_t> lost{0};  ///< snapshots or events that found their ring full
};

}  // namespace gantry::cycle
