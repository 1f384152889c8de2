// CiA 402's state machine as two pure tables: what a statusword says, and which controlword leads from a state towards
// a goal. Masks, never equality: bits 8 to 15 vary from drive to drive while the state is the same.
//   const auto state = decode(0x1237);                               // OperationEnabled
//   word = next_controlword(state, DriveGoal::Enabled, word);
// Lives in the RT loop.
#pragma once
#include <cstdint>

#include "devices/wire/cia402.hpp"

namespace gantry::devices {

using wire::DriveState;

/// Where the drive shall be. A fault is left by FaultReset alone, and no goal leads up again by itself after it.
enum class DriveGoal : std::uint8_t {
  Disabled,    ///< no torque, voltage disabled (coasts, or the brake falls)
  Ready,       ///< ready to switch on: no torque
  SwitchedOn,  ///< power stage on, no torque
  Enabled,     ///< follows its targets
  QuickStop,   ///< the drive's own quick stop (605Ah)
  FaultReset,  ///< rising edge of bit 7 when in fault; a drive without a fault is treated as by Disabled
};

/// State of a statusword (IEC 61800-7-201, table of state coding): mask 0x4F for the states in which bit 5 does not
/// count (a fault shows 0x0218 on one drive and 0x0638 on another), 0x6F for the others.
DriveState decode(std::uint16_t statusword) noexcept;

/// The controlword (bits 0-3 and 7) that leads from `state` towards `goal`; `last` is the word sent before, which
/// matters only for FaultReset: bit 7 is 0 and 1 in turn, so that every second word is a rising edge.
std::uint16_t next_controlword(DriveState state, DriveGoal goal, std::uint16_t last) noexcept;

/// Whether `state` is what `goal` asks for: nothing more is to happen.
bool reached(DriveState state, DriveGoal goal) noexcept;

/// Whether the state of one cycle may follow that of the cycle before. Downwards (towards no torque or a fault)
/// everything may; upwards one step a cycle; out of a fault only to switch-on disabled (R41).
bool may_follow(DriveState before, DriveState now) noexcept;

}  // namespace gantry::devices
