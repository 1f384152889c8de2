// Reading a station's SII EEPROM through the ESC (ETG.1000.4, 6.4; registers 0500h-050Fh).
//   auto vendor = read_sii(link, station.address, wire::sii::kVendor);
#pragma once
#include <cstdint>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// Two words from word address `word`. Fault::SiiInvalid when the EEPROM reports an error or stays busy for 100 ms.
Result<std::uint32_t> read_sii(Link& link, std::uint16_t station, std::uint16_t word);

/// Identity and standard mailbox of a station.
Result<StationSii> read_station_sii(Link& link, std::uint16_t station);

}  // namespace gantry::devices
