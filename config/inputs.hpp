// What the loop's input word says of an input that the machine may lack.
//   if (config::is_low(machine, snapshot.inputs, Input::ClampClosed)) ...
#pragma once
#include <cstdint>

#include "config/machine.hpp"

namespace gantry::config {

/// The machine has this input, and it is off.
inline bool is_low(const Machine& machine, std::uint32_t word, Input input) {
  return machine.inputs[static_cast<std::size_t>(input)].has_value() && (word & bit(input)) == 0;
}

}  // namespace gantry::config
