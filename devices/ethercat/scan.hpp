// Who is on the bus: counts the stations, gives each an address, reads what it says it is and who it is connected to,
// and compares with the machine file.
//   auto found = find_stations(link);                       // anybody, as they are: no state is changed
//   auto stations = scan(link, machine, strangers, notes);  // those of the machine file, in INIT and clean
#pragma once
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

inline constexpr int kMaxStations = 256;

/// A configured station address by position.
constexpr std::uint16_t station_address(int position) { return static_cast<std::uint16_t>(0x1001 + position); }

/// Stations that answer. Fault::BusDown; Fault::StationMissing when there are more than kMaxStations.
Result<int> count_stations(Link& link);

/// Records of all stations that answer, by position: address given, ESC, ports and parent, alias and the EEPROM read
/// (sii.damage says when it cannot be; whoever had it has it again). No state is changed. Fault::StationMissing,
/// BusDown.
Result<std::vector<StationRecord>> find_stations(Link& link);
/// Those that had no address when they were found have none again. A station forgets its address with its supply, and
/// that is how it is known later that it has restarted: whoever only looks must not wipe it out. Best effort; one that
/// is not reached keeps its address, and counts as one that has not restarted.
void give_back_addresses(Link& link, const std::vector<StationRecord>& stations);
/// Reads the EEPROM's categories too.
Result<void> read_whole_sii(Link& link, StationRecord& station);

/// Its processor has the EEPROM from now on (0500h): before it is asked for PRE_OP.
Result<void> hand_over_eeprom(Link& link, StationRecord& station);

/// Brings every station to a known beginning: INIT, no SYNC0, no FMMU, no sync manager, no alias addressing, error
/// counters 0; the bus has the EEPROM.
Result<void> reset_stations(Link& link);
/// The same of one.
Result<void> reset_station(Link& link, const StationRecord& station);

/// Records of the machine's EtherCAT stations in the order of their positions, reset, with what was found and what is
/// to be written. With `strangers`, a machine file without EtherCAT stations takes whatever answers (StationId is the
/// position then). Fault::StationMissing when the number differs, Fault::IdentityMismatch when another device than
/// configured, or than was accepted, stands at a position, Fault::SiiInvalid.
Result<std::vector<StationRecord>> scan(Link& link, const config::Machine& machine, bool strangers,
                                        std::vector<std::string>& notes);

/// Fault::StationMissing where another number of stations answers than the machine file has on EtherCAT.
Result<void> check_count(const config::Machine& machine, std::size_t count);

/// How an error names a station of the machine file: "station 2 'y1'".
std::string where(const config::Station& station);

/// Fault::IdentityMismatch where the machine file states another alias than was found.
Result<void> check_alias(const config::Machine& machine, const config::Station& station, const StationRecord& found);

/// The comparison alone. An empty string: nothing to say; otherwise a note.
Result<std::string> check_identity(const config::Machine& machine, const config::Station& station,
                                   const StationSii& found);

}  // namespace gantry::devices
