// The PDO mapping of a station's record, written by SDO before it exchanges process data (PRE_OP).
//   write_pdo_mapping(link, station);
// Blocking, off the RT side.
#pragma once
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// PDO mapping (PRE_OP), in the order that the stations demand: 1C12:0 = 0, each 16xx:0 = 0, entries, 16xx:0 = n,
/// 1C12:1.., 1C12:0 = m. Everything is read back: Fault::PdoMappingDiffers. Nothing for stations without mailbox or
/// with a fixed mapping.
Result<void> write_pdo_mapping(Link& link, StationRecord& station);

}  // namespace gantry::devices
