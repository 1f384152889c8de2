// What `gantry commission` has accepted of each station, kept in the machine's state folder: identities, and which
// stations hold parameters that do not act before their next power-up. A file for each kind of bus: what the virtual
// drives are says nothing of those of steel.
//   auto file = accepted_file(state, "ethercat:enp3s0");   read_accepted(file, machine);   write_accepted(file,
//   machine);
#pragma once
#include <string>

#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::stations {

std::string accepted_file(const std::string& state, const std::string& bus);

/// Into `machine.stations`, by name. A file that is not there accepts nothing. Fault::FileUnreadable, BadValue with
/// what to do.
Result<void> read_accepted(const std::string& file, config::Machine& machine);
/// Of every station that has something accepted; what the file says of stations that `machine` does not have goes.
/// Fault::FileUnwritable.
Result<void> write_accepted(const std::string& file, const config::Machine& machine);

}  // namespace gantry::stations
