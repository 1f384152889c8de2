// What the loss of the bus or of the program costs on a machine, for `check`.
//   for (const auto& note : bus_notes(machine)) ...   // recipes/bus_notes.hpp: at the speeds of a recipe
#pragma once
#include <string>
#include <vector>

#include "config/machine.hpp"

namespace gantry::config {

/// A sentence for each axis that is left to its station, for the valve, and for how far X and Y travel at full speed.
std::vector<std::string> bus_notes(const Machine& machine);

}  // namespace gantry::config
