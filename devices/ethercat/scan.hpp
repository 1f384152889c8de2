// Who is on the bus: counts the stations, gives each an address, reads what its EEPROM says it is, and compares with
// the machine file.
//   auto stations = scan(link, machine, notes);
#pragma once
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// A configured station address by position.
constexpr std::uint16_t station_address(int position) { return static_cast<std::uint16_t>(0x1001 + position); }

/// Stations that answer. Fault::BusDown.
Result<int> count_stations(Link& link);

/// Brings every station to a known beginning (INIT, no SYNC0, no FMMU, no sync manager) and gives it its address.
Result<void> reset_stations(Link& link, int count);

/// Records of the machine's EtherCAT stations in the order of their positions, with what was found.
/// Fault::StationMissing when the number differs, Fault::IdentityMismatch when another device than configured stands at
/// a position (an assumed identity that differs gives a note, unless it is that of another station of the machine),
/// Fault::SiiInvalid.
Result<std::vector<StationRecord>> scan(Link& link, const config::Machine& machine, std::vector<std::string>& notes);

/// The comparison alone. An empty string: nothing to say; otherwise a note.
Result<std::string> check_identity(const config::Machine& machine, const config::Station& station,
                                   const StationSii& found);

}  // namespace gantry::devices
