// The end of cyclic operation: every station goes down from OP over SAFE_OP and PRE_OP to INIT, and each state is
// waited for before the next one is asked for. A station that is asked too fast, or whose SYNC0 ends while it is in OP,
// stays behind in SAFE_OP with an error (AL status codes 001Bh, 002Ch) and greets the next start with it.
//   const auto left = leave_operation(link, stations, machine.bus.cycle, [&] { exchange outputs of 0; });
// Ends in bounded time, whatever stations do: one that is dead is given up after a few looks, one that is slow gets
// kLeavePatience for each state. Off the RT side.
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// The longest that leave_operation() waits for slow stations in all; a bus that is silent ends it earlier.
inline constexpr Time kLeaveAtMost = milliseconds(1400);

/// `exchange` keeps the output watchdogs of stations that are still in OP from expiring; it is called once a `cycle`
/// for as long as there are any. The link must own the port (nobody exchanges any more). Errors that stations show are
/// acknowledged; SYNC0 is switched off where a station no longer needs it (PRE_OP). Gives a sentence for each station
/// that could not be brought to INIT; empty when all are there.
std::vector<std::string> leave_operation(Link& link, std::span<const StationRecord> stations, Time cycle,
                                         const std::function<void()>& exchange);

}  // namespace gantry::devices
