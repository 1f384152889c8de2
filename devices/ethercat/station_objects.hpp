// The PDO mapping of a station's record, written by SDO before it exchanges process data (PRE_OP).
//   write_pdo_mapping(link, station);
// Blocking, off the RT side.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// Start-up objects that a drive may do without are dropped from the record where the station does not have them, with
/// a note: 609Ah.
Result<void> leave_out_absent(Link& link, StationRecord& station, std::vector<std::string>& notes);

/// One direction of the mapping; `aborted`: the abort code, where the station has refused.
Result<void> write_direction(Link& link, StationRecord& station, bool outputs, std::uint32_t* aborted = nullptr);
/// CSP by SDO, for each axis whose mode is in no PDO.
Result<void> set_first_mode(Link& link, StationRecord& station);

/// PDO mapping (PRE_OP), in the order that the stations demand: 1C12:0 = 0, each 16xx:0 = 0, entries, 16xx:0 = n,
/// 1C12:1.., 1C12:0 = m. Everything is read back: Fault::PdoMappingDiffers. Nothing for stations without mailbox or
/// with a fixed mapping, or for the half of it that the station has been found to fix.
Result<void> write_pdo_mapping(Link& link, StationRecord& station);

}  // namespace gantry::devices
