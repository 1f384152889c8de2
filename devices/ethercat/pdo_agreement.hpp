// Finds a mapping that the station takes, when it does not take the profile's: other sizes, entries that cannot be
// mapped, 8-bit entries last and padded, mapping objects with other numbers, or a mapping that cannot be written at
// all.
//   if (auto ok = agree_on_pdos(link, station, probe_slot, notes); !ok) ...     // PRE_OP; s.rx_pdos and s.tx_pdos are
//   the station's then
// What the loop needs in every cycle (devices/profiles/drive_entries.hpp) has to be in it. A station that takes its
// profile's mapping costs nothing more.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// Outputs of a mapping that is the station's own are sent whatever the loop knows of them, and zeros would take a
/// drive's speed or torque: what each of these objects holds goes out instead. Behind the start-up objects.
/// Fault::PdoMappingDiffers names the one that cannot be read.
Result<void> learn_foreign_outputs(Link& link, StationRecord& station, std::vector<std::string>& notes);

/// Writes the mapping, reads it back, and bends it where the station refuses. What is lost by that is told in `notes`
/// and stands in s.slow where SDO can replace it. `probe_slot`: the axis of the station that has the machine's touch
/// probe, whose entries nothing can replace; where only some find room, they come before those that SDO can.
/// Fault::PdoMappingDiffers names the object and what the station said.
Result<void> agree_on_pdos(Link& link, StationRecord& station, std::optional<int> probe_slot,
                           std::vector<std::string>& notes);

}  // namespace gantry::devices
