// Inputs without which no drive has torque: one table for whoever enables, for the supervision of every cycle, and for
// whoever tells people what is open. Each is 1 while all is well, and one that the machine lacks is never missing.
//   for (const Interlock& lock : kInterlocks) if (is_open(lock, setup, inputs)) ...
// RT: a constant table.
#pragma once
#include <array>
#include <cstdint>

#include "app/cycle/loop_setup.hpp"
#include "config/machine.hpp"
#include "core/fault.hpp"

namespace gantry::cycle {

struct Interlock {
  config::Input input;
  std::uint32_t LoopSetup::*mask;
  Fault open;
  bool in_setup;  ///< in setup, too
};

/// The gravest first.
inline constexpr std::array kInterlocks{
    Interlock{config::Input::SafetyOk, &LoopSetup::safety_mask, Fault::SafetyChainOpen, true},
    Interlock{config::Input::Stop, &LoopSetup::stop_mask, Fault::StopPressed, true},
    Interlock{config::Input::DoorClosed, &LoopSetup::door_mask, Fault::DoorOpen, false},
    Interlock{config::Input::AirOk, &LoopSetup::air_mask, Fault::AirMissing, true},
};

/// The mode switch says so. `inputs`: the loop's input word.
constexpr bool in_setup(const LoopSetup& setup, std::uint32_t inputs) noexcept {
  return setup.mode_mask != 0 && (inputs & setup.mode_mask) == 0;
}

constexpr bool is_open(const Interlock& lock, const LoopSetup& setup, std::uint32_t inputs) noexcept {
  const std::uint32_t mask = setup.*lock.mask;
  return mask != 0 && (inputs & mask) == 0 && (lock.in_setup || !in_setup(setup, inputs));
}

}  // namespace gantry::cycle
