// Where the process data of every station lie: in the two images of the controller, in the logical map that the cyclic
// frames carry, and in the station's own memory (SyncManager lengths, FMMUs).
//   const auto size = lay_out(stations, start, MapKind::Separate);   // then write_process_data() for each station
// Pure: nothing is sent. Off the RT side.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

struct ImageSize {
  std::size_t output_bytes = 0, input_bytes = 0;
};

using config::MapKind;

/// Entries and bytes of each PDO against what the device takes. Fault::PdoMappingDiffers.
Result<void> check_pdo_limits(const StationRecord& station);

/// A direction may have several SyncManagers, one FMMU each; in the map they lie in the order of their numbers.
/// Fills in the record of every station: SyncManager lengths, FMMUs, its offsets in the images and in the logical map.
/// Fault::Inconsistent when a station has PDOs but no
/// SyncManager for them, several that do not fill whole bytes, more process data than a frame carries, or areas that
/// its ESC cannot have (check_areas()).
Result<ImageSize> lay_out(std::vector<StationRecord>& stations, std::uint32_t logical_start, MapKind kind);

}  // namespace gantry::devices
