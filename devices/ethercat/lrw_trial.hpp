// Some stations cannot serve LRW (one datagram that writes outputs and reads inputs) and do not say so in their
// features. They are found by trying.
//   const auto changed = try_lrw(link, stations, notes);   // SAFE_OP; more than 0: the cycle is to be laid out again
// Blocking, off the RT side.
#pragma once
#include <string>
#include <vector>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// Tries LRW with outputs of 0 on the stations that do not say otherwise (SAFE_OP). One that lets LRW pass and counts
/// for LWR and LRD gets those from now on (StationRecord::lrw) and a note. How many changed. Fault::BusDown.
Result<int> try_lrw(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes);

}  // namespace gantry::devices
