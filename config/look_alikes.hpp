// Stations that answer alike: only an alias, or a person who has watched their axes move (a walk) tells which of them
// stands where; serials that were accepted then notice when they are exchanged. Where none of them does, swapped cables
// make the one take the other's orders.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/machine.hpp"

namespace gantry::config {

/// On one EtherCAT line, of one profile, or of one vendor and product.
bool look_alike(const Station& a, const Station& b);

/// What the machine file says of which axis a station moves, and which way: "position 1; X: slot 0; direction 0"; ""
/// for a station that moves none. When that has changed since a walk, the walk says nothing any more.
std::string wiring_of(const Machine& machine, const Station& station);
/// A person has seen its axes move as the machine file says today.
bool walked(const Machine& machine, const Station& station);

/// A sentence for each kind of station of which two are told apart by nothing, or by a walk alone, with the remedy.
std::vector<std::string> look_alikes(const Machine& machine);

/// The serial number that a station shows now; nothing where it was not found.
using SerialNow = std::function<std::optional<std::uint32_t>(const Station&)>;

struct Alike {
  StationId station;  ///< the first of the two
  std::string text;   ///< a sentence with the remedy
};
/// Drives that look alike and of which nothing says that each stands in its place.
std::vector<Alike> not_told_apart(const Machine& machine, const SerialNow& serial);

}  // namespace gantry::config
