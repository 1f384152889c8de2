// Whether a station can take what is about to be written to it, checked before SAFE_OP. Stations refuse a wrong length
// or areas over each other with a bare code, or do not look; here the message names both sides.
//   check_areas(station);                  // SyncManagers against each other, the RAM, and the ESC's numbers
//   check_fixed_map(link, station);        // a mapping that is not written, against what the station says it has
// Off the RT side.
#pragma once
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// Process data lie in three buffers one behind the other (ESC data sheet I, 8.1), mailboxes in one.
/// Fault::Inconsistent when an area reaches over another or over the end of the RAM, or when the ESC has fewer
/// SyncManagers or FMMUs.
Result<void> check_areas(const StationRecord& station);

/// Laid out (see lay_out()), in PRE_OP. By the station's own objects 1C1xh and 16xxh, 1Axxh where it has CoE, else by
/// its EEPROM's SyncManager lengths or PDOs. Fault::PdoMappingDiffers with both lengths, or the object that stands
/// elsewhere. Nothing for stations whose mapping we write and read back, and for strangers.
Result<void> check_fixed_map(Link& link, StationRecord& station);

}  // namespace gantry::devices
