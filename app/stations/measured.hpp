// What `gantry commission AXIS` has measured of the axes, with the date, in the machine's state folder beside what was
// accepted of the stations. A file for each kind of bus: what the virtual drives need says nothing of those of steel.
//   auto file = measured_file(state, "ethercat:enp3s0");   read_measured(file, machine);   write_measured(file,
//   machine);
#pragma once
#include <string>

#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::stations {

std::string measured_file(const std::string& state, const std::string& bus);

/// Into `machine.axes`, by name. A file that is not there has measured nothing. Fault::FileUnreadable, BadValue.
Result<void> read_measured(const std::string& file, config::Machine& machine);
/// Of every axis that was measured. Fault::FileUnwritable.
Result<void> write_measured(const std::string& file, const config::Machine& machine);

/// "3 ms are stated, 3.02 ms were found (within 0.02 ms, at 50 mm/s, 2026-11-23)", and what to do where they differ.
std::string measured_in_words(const config::Axis& axis);

}  // namespace gantry::stations
