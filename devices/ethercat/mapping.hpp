// Process data of the stations: where everything lies in the logical map, what is written to SyncManagers and FMMUs,
// and the PDO mapping by SDO with its readback.
//   lay_out(stations, start, MapKind::Separate) -> ImageSize;   write_pdo_mapping(link, station);
//   write_process_data(link, station);
#pragma once
#include <string>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

struct ImageSize {
  std::size_t output_bytes = 0, input_bytes = 0;
};

using config::MapKind;

/// A direction may have several SyncManagers, one FMMU each; in the map they lie in the order of their numbers.
/// Fills in the record of every station (SyncManager lengths, FMMUs, places in the images and in the logical map).
/// Fault::PdoMappingDiffers when a PDO is over the device's limits, Fault::Inconsistent when a station has PDOs but no
/// SyncManager for them, several that do not fill whole bytes, more process data than a frame carries, or areas that
/// its ESC cannot have (check_areas()).
Result<ImageSize> lay_out(std::vector<StationRecord>& stations, std::uint32_t logical_start, MapKind kind);

/// Configures the mailbox (INIT, before PRE_OP): by the station's own SII where it says something. The record's mailbox
/// state is new before.
Result<void> write_mailbox_setup(Link& link, StationRecord& station);

/// Start-up objects of the profile in order (PRE_OP). With `compare_first`, equal values are left alone.
Result<void> write_startup(Link& link, StationRecord& station);

/// PDO mapping (PRE_OP), in the order that the stations demand: 1C12:0 = 0, each 16xx:0 = 0, entries, 16xx:0 = n,
/// 1C12:1.., 1C12:0 = m. Everything is read back: Fault::PdoMappingDiffers. Nothing for stations without mailbox or
/// with a fixed mapping.
Result<void> write_pdo_mapping(Link& link, StationRecord& station);

/// SyncManagers and FMMUs of process data and the output watchdog (PRE_OP, before SAFE_OP is asked for). The watchdog
/// is read back, and so is that the outputs' SyncManagers trigger it: Fault::WatchdogDisabled when it is off.
Result<void> write_process_data(Link& link, const StationRecord& station);

/// Whether stations that do not say otherwise take LRW, by trying it (SAFE_OP, outputs 0): one that lets LRW pass and
/// counts for LWR and LRD gets those from now on (StationRecord::lrw) and a note. How many changed. Fault::BusDown.
Result<int> try_lrw(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes);

}  // namespace gantry::devices
