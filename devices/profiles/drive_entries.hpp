// What of a drive's mapping the loop needs in every cycle, what the mailbox can carry as well, and what may be missing
// at a price. Indices are those of the first axis.
#pragma once
#include <array>
#include <cstdint>

#include "devices/wire/cia402.hpp"

namespace gantry::devices {

enum class EntryNeed : std::uint8_t {
  EveryCycle,  ///< without it the station is refused
  ByMailbox,   ///< where no PDO carries it, SDO does
  Probe,       ///< left out; the touch probe of that axis does not work then
};
struct DriveEntry {
  std::uint16_t index;
  bool output;
  std::uint8_t bits;
  bool has_sign;
  EntryNeed need;
  const char* name;
  const char* cost;         ///< of not being in a PDO
  const char* absent = "";  ///< of not being there at all, where SDO would do otherwise
  const char* silent = "";  ///< what it means that it is read by SDO and does not answer any more
};
inline constexpr std::array kDriveEntries{
    DriveEntry{wire::cia402::kControlword, true, 16, false, EntryNeed::EveryCycle, "controlword", ""},
    DriveEntry{wire::cia402::kTargetPosition, true, 32, true, EntryNeed::EveryCycle, "target position", ""},
    DriveEntry{wire::cia402::kStatusword, false, 16, false, EntryNeed::EveryCycle, "statusword", ""},
    DriveEntry{wire::cia402::kActualPosition, false, 32, true, EntryNeed::EveryCycle, "actual position", ""},
    DriveEntry{wire::cia402::kMode, true, 8, true, EntryNeed::ByMailbox, "mode",
               "the mode is set by SDO, so each change of it takes some mailbox messages longer"},
    DriveEntry{wire::cia402::kModeDisplay, false, 8, true, EntryNeed::ByMailbox, "mode display",
               "the mode is read back by SDO, so a drive that changes it by itself is noticed late",
               "6060h is read back instead, which shows what was asked and not what the drive does",
               "a drive that leaves its mode by itself is not noticed, and a change that is asked for is not seen"},
    DriveEntry{
        wire::cia402::kDigitalInputs, false, 32, false, EntryNeed::ByMailbox, "digital inputs",
        "limit and home switches are read by SDO, so the controller sees them late, and homing stops when they fall "
        "silent; the drive's own reaction stays",
        "the controller does not see limit and home switches, and does not home this axis unless the machine file says "
        "`homing: {limits_unseen: true}`; then only the drive reacts to them",
        "homing ends; any other motion goes on, and a switch that it meets is noticed by the drive alone, and by its "
        "statusword where that has a bit for it"},
    DriveEntry{wire::cia402::kErrorCode, false, 16, false, EntryNeed::ByMailbox, "error code",
               "it is read by SDO, so a fault is named late, and a warning is noticed late",
               "faults are told without their code, and warnings not at all",
               "a fault is told by the code that was read last, and warnings are not noticed"},
    DriveEntry{wire::cia402::kProbeFunction, true, 16, false, EntryNeed::Probe, "probe function",
               "this axis cannot use a touch probe"},
    DriveEntry{wire::cia402::kProbeStatus, false, 16, false, EntryNeed::Probe, "probe status",
               "this axis cannot use a touch probe"},
    DriveEntry{wire::cia402::kProbe1Rising, false, 32, true, EntryNeed::Probe, "probe position",
               "this axis cannot use a touch probe"},
};
/// By its index on the first axis; nullptr: none that the loop knows.
constexpr const DriveEntry* find_drive_entry(std::uint16_t index) noexcept {
  for (const auto& e : kDriveEntries)
    if (e.index == index) return &e;
  return nullptr;
}

}  // namespace gantry::devices
