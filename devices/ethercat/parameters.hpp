// The values that a station must hold before it may have torque (the start-up rows of its record): compared, written
// where they may be, read back. What stays otherwise is a doubt about the station.
//   write_startup(link, station);                     // bring-up and recovery; station.doubts
//   auto held = read_held(link, station, row);        // commissioning
// Blocking, off the RT side.
#pragma once
#include <span>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// A value was not taken: the station has said so, or it was never sent. Any other error of a write (a time-out, a bus
/// that is gone) leaves open whether the station has it now.
[[nodiscard]] bool is_refusal(const Error& of_write);

/// Start-up objects in order (PRE_OP): read, compared, written where they differ and may be written, read back. What is
/// still another value then, or is refused, becomes one of the station's `doubts`, which keep torque from it; what it
/// has ignored is not written again before its next power-up. An error is a mailbox that does not answer.
/// Fault::RestartNeeded where it may hold values that act at its next power-up.
std::optional<Error> needs_restart(const config::Station& station, bool since_power_up, const std::string& where);

Result<void> write_startup(Link& link, StationRecord& station);

/// One of the same rows, read once more while the drive has torque: if it holds another value now, that becomes a
/// doubt. What it does not show then is passed over; an error is a mailbox that does not answer.
Result<void> compare_held(Link& link, StationRecord& station, const config::StartupRow& row);

/// One start-up object as the station holds it. The size is the station's: manuals print others.
struct HeldObject {
  std::int64_t value = 0;
  std::size_t bytes = 0;
};
Result<HeldObject> read_held(Link& link, StationRecord& station, const config::StartupRow& row);
/// Written in the station's own size. Fault::OutOfRange where it does not fit.
Result<void> write_held(Link& link, StationRecord& station, const config::StartupRow& row, std::size_t bytes);

/// Has the station keep over its next power-up what was written to these objects, where that takes an order of its own
/// (AMD530B 8.1: "save" to 1010h:1 for 6000h, to 1010h:2 for 2000h). The whole group is kept by that.
Result<void> save_parameters(Link& link, StationRecord& station, const config::StationProfile& profile,
                             std::span<const config::ObjectAddress> written);

}  // namespace gantry::devices
