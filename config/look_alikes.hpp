// Stations that answer alike: only an alias (or a serial that was accepted) tells which of them stands where. Where
// neither does, swapped cables make the one take the other's orders.
#pragma once
#include <string>
#include <vector>

#include "config/machine.hpp"

namespace gantry::config {

/// On one EtherCAT line, of one profile, or of one vendor and product.
bool look_alike(const Station& a, const Station& b);

/// A sentence for each kind of station of which two are told apart by nothing, with the remedy.
std::vector<std::string> look_alikes(const Machine& machine);

}  // namespace gantry::config
