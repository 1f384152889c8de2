// The SII EEPROM of a virtual station, built from its profile: identity, mailboxes, and the categories that a master
// reads to know the station without an ESI file (ETG.2010).
//   auto image = sii_image(profile, alias, serial);   // bytes, little-endian words, ends with FFFFh
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "config/drive.hpp"
#include "sim/objects/clock_mode.hpp"

namespace gantry::sim {

/// Never empty; an even number of bytes. `clock`: the one operation mode that it names, instead of SYNC0 and none.
std::vector<std::byte> sii_image(const config::StationProfile& profile, std::uint16_t alias, std::uint32_t serial,
                                 const std::optional<ClockMode>& clock = {});

/// The profile's SyncManagers as the station has them at power-on: mailboxes with their length, process data with the
/// length of the default mapping. Where the profile names none (assumed): mailboxes of 128 bytes at 1000h and 1080h
/// for a station that has objects, process data at 1100h and 1400h.
std::vector<config::SyncManagerRow> sync_managers(const config::StationProfile& profile);

}  // namespace gantry::sim
