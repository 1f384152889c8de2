// Bringing a station back while the others go on exchanging: found again, and its whole record written again (address,
// mailbox, start-up objects, PDO map, SyncManagers, FMMUs, watchdog, clock, SYNC0), as at bring-up. Everything goes
// through the link, which rides in the loop's frames meanwhile.
//   auto where = look_for(link, station);      if (*where != Whereabouts::InOp) replay(link, station, ...);
// Off the RT side; every call ends in bounded time.
#pragma once
#include <cstdint>

#include "core/error.hpp"
#include "devices/ethercat/dc_setup.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

enum class Whereabouts : std::uint8_t {
  Gone,       ///< nobody answers at its address or its position
  Forgetful,  ///< it answers, but it has lost its power: everything is to be written
  Fallen,     ///< it has kept what was written, but left OP (its watchdog, a lost clock)
  InOp,
};

/// Asks at its address, and when that is silent at its position: a station that answers there without an address has
/// lost its power; if it is the same device (vendor, product, serial number) it gets its address again.
/// Fault::IdentityMismatch when another device stands there.
Result<Whereabouts> look_for(Link& link, StationRecord& station);

/// From INIT to OP by its record; the time of `clock_source` (station address; 0: the machine's clock) is the one that
/// the others kept. Faults as at bring-up.
Result<void> replay(Link& link, StationRecord& station, const DcSetup& dc, std::uint16_t clock_source, Time cycle);

/// Acknowledges its error and asks for OP again, with everything as it is.
Result<void> pick_up(Link& link, const StationRecord& station);

}  // namespace gantry::devices
