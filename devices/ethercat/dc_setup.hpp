// Distributed clocks (ETG.1000.4, 6.5): propagation delays over the tree of stations, one common time, its drift taken
// out, and SYNC0 of all stations from one common start.
//   auto dc = set_up_clocks(link, stations, notes);            // PRE_OP
//   start_sync0(link, stations, *dc, machine.bus.cycle);       // PRE_OP, before SAFE_OP
// DC time is the machine's clock at the moment of set-up: SYNC0 comes at whole cycles of it.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

struct DcSetup {
  std::uint16_t reference_address = 0;  ///< 0: no station has clocks
  bool reference_wide = true;           ///< its clock counts 64 bits, otherwise 32
};

/// Marks the stations that take part. Stations whose clocks do not come within a microsecond give a note
/// (Fault::DcNotLocked is the running monitor's). Ends within a second of bus time.
Result<DcSetup> set_up_clocks(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes);

/// Brings a station that has come back to the time that the others kept: its offset from one frame that passes `source`
/// (station address of another clock; 0: the machine's clock) and it; then the cycle's FRMW takes out the rest.
/// Fault::DcNotLocked when it is not within a microsecond after half a second.
Result<void> rejoin_clocks(Link& link, const StationRecord& station, const DcSetup& dc, std::uint16_t source);

/// Fault::DcLost when the common start was past before the last station knew of it.
Result<void> start_sync0(Link& link, std::span<const StationRecord> stations, const DcSetup& dc, Time cycle);

}  // namespace gantry::devices
