// From a profile's PDO rows to offsets in the station's process image: the same rows that bring-up writes to the
// station.
//   auto layout = map_drive(station.profile, slot);      // then Drive(*layout, scale)
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "config/drive.hpp"
#include "core/error.hpp"
#include "devices/rt/drive.hpp"

namespace gantry::devices {

/// Bytes that PDOs fill in the image, the last one padded.
std::size_t image_bytes(std::span<const config::PdoRow> pdos);

struct MappedBits {
  std::size_t bit = 0, bits = 0;
};
/// Where an object (address as on the wire) lies in the image; nothing when it is not mapped.
std::optional<MappedBits> find_bits(std::span<const config::PdoRow> pdos, config::ObjectAddress object);

/// First bit of an object (address as on the wire) in the image; nothing when it is not mapped.
std::optional<std::size_t> find_mapped(std::span<const config::PdoRow> pdos, config::ObjectAddress object);

/// The loop's image: the profile's, in which what may have another size than the standard's has the standard's. The
/// station's own goes through BentImage then.
std::vector<config::PdoRow> loop_rows(const config::StationProfile& profile, bool outputs);
/// Whether that is the profile's as it stands.
bool as_loop_has_it(const config::StationProfile& profile);

/// Which of our faults a code of a drive becomes.
CodeMeaning meaning(const config::DriveErrorRow& row);

/// Where axis `slot` of a drive lives in its station's image, with the facts that the loop needs. Fault::Inconsistent
/// when the station is no drive, or when 6040h or 6041h is missing, not on a whole byte or of another size.
Result<DriveLayout> map_drive(const config::StationProfile& profile, int slot);

}  // namespace gantry::devices
