// Several axes behind one station: where an object of axis `slot` lives (STD402EC, manual 10.1: 6xxxh + 800h, 2xxxh +
// 200h per axis). Profiles write objects as those of the first axis.
#pragma once
#include "config/drive.hpp"

namespace gantry::devices {

inline config::ObjectAddress at_slot(const config::StationProfile& profile, config::ObjectAddress first, int slot) {
  const unsigned stride = first.index >= 0x6000 ? profile.slot_stride : profile.slot_stride_vendor;
  const bool per_axis = first.index >= 0x2000 && first.index < 0xA000;
  const unsigned index = first.index + (per_axis ? static_cast<unsigned>(slot) * stride : 0u);
  return {static_cast<std::uint16_t>(index), first.sub};
}

/// Address of a mapped object as it goes over the wire. A PDO of a further axis may name its objects either way: as the
/// first axis has them, or with the stride already added.
inline config::ObjectAddress mapped_object(const config::StationProfile& profile, const config::PdoRow& pdo,
                                           const config::PdoEntry& entry) {
  const bool of_first_axis = entry.address.index >= 0x6000 && entry.address.index < 0x6000u + profile.slot_stride;
  return pdo.slot > 0 && of_first_axis ? at_slot(profile, entry.address, pdo.slot) : entry.address;
}

}  // namespace gantry::devices
