// Distributed clocks (ETG.1000.4, 6.5): propagation delays along the line, one common time, its drift taken out, and
// SYNC0 of all stations from one common start.
//   auto dc = set_up_clocks(link, stations, notes);            // PRE_OP
//   start_sync0(link, stations, *dc, machine.bus.cycle);       // PRE_OP, before SAFE_OP
// DC time is the machine's clock at the moment of set-up: SYNC0 comes at whole cycles of it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

struct DcSetup {
  std::uint16_t reference_address = 0;  ///< 0: no station has clocks
};

/// Marks the stations that take part. Stations whose clocks do not come within a microsecond give a note
/// (Fault::DcNotLocked is the running monitor's). Ends within a second of bus time.
Result<DcSetup> set_up_clocks(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes);

/// Fault::DcLost when the common start was past before the last station knew of it.
Result<void> start_sync0(Link& link, const std::vector<StationRecord>& stations, const DcSetup& dc, Time cycle);

/// Delays of a line from the receive times of ports 0 and of the last open port (ns, wrapping): half the difference of
/// the round trips behind two neighbours is the way between them.
std::vector<std::uint32_t> line_delays(const std::vector<std::uint32_t>& round_trip_ns);

}  // namespace gantry::devices
