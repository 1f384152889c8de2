// What is written to the registers of a station's ESC: SyncManagers of the mailbox and of process data, FMMUs, and the
// watchdog of its outputs. All of it comes from the station's record.
//   write_mailbox_setup(link, station);   // INIT          write_process_data(link, station);   // PRE_OP
// Blocking, off the RT side.
#pragma once
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// Configures the mailbox (INIT, before PRE_OP): by the station's own SII where it says something. The record's mailbox
/// state is new before.
Result<void> write_mailbox_setup(Link& link, StationRecord& station);

/// SyncManagers and FMMUs of process data and the output watchdog (PRE_OP, before SAFE_OP is asked for; the record has
/// gone through lay_out()). The watchdog is read back, and so is that the outputs' SyncManagers trigger it:
/// Fault::WatchdogDisabled when it is off.
Result<void> write_process_data(Link& link, const StationRecord& station);

}  // namespace gantry::devices
