#include "devices/ethercat/station_registers.hpp"

namespace gantry::devices {
namespace {

using namespace wire;
using config::SyncManagerKind;

constexpr std::uint16_t kWatchdogUnitsPerMs = 10;  // of 100 us each

std::uint16_t sm_register(std::size_t number, std::size_t byte) {
  return static_cast<std::uint16_t>(reg::kSyncManager0 + kSyncManagerBytes * number + byte);
}

Result<void> write_sync_manager(Link& link, const StationRecord& s, std::size_t number) {
  SyncManager registers = s.sync_managers[number].registers;
  if (s.sync_managers[number].is(SyncManagerKind::MailboxIn) && s.mailbox.repeat_toggle)
    registers.activate |= kSmActivateRepeatRequest;
  const auto raw = to_bytes(registers);
  return link.write(s.address, sm_register(number, 0), std::span<const std::byte>(raw));
}

}  // namespace

Result<void> write_mailbox_setup(Link& link, StationRecord& s) {
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i) {
    if (!s.sync_managers[i].is_mailbox()) continue;
    if (s.sync_managers[i].is(SyncManagerKind::MailboxIn)) {
      // The request bit begins as the station has acknowledged it last: a difference would ask it to repeat a message
      // of the time before.
      const auto acknowledged = link.read<std::uint8_t>(s.address, sm_register(i, kSmPdiControlOffset));
      if (!acknowledged) return tl::unexpected(acknowledged.error());
      s.mailbox.repeat_toggle = (*acknowledged & kSmPdiRepeatAck) != 0;
    }
    if (auto ok = write_sync_manager(link, s, i); !ok) return ok;
  }
  return {};
}

namespace {

Result<void> write_watchdog(Link& link, const StationRecord& s) {
  if (s.output_bytes == 0) return {};
  const auto units = static_cast<std::uint16_t>(s.watchdog_ms * kWatchdogUnitsPerMs);
  const auto off = [&] {
    return fail(Fault::WatchdogDisabled,
                "the process-data watchdog is off, so outputs would stay on when the bus is lost; set watchdog_ms in "
                "the profile, or see why the station does not take it",
                s.where);
  };
  if (units == 0) return off();
  if (auto ok = link.write<std::uint16_t>(s.address, reg::kWatchdogDivider, kWatchdogDivider100us); !ok) return ok;
  if (auto ok = link.write<std::uint16_t>(s.address, reg::kWatchdogTimeProcessData, units); !ok) return ok;
  const auto divider = link.read<std::uint16_t>(s.address, reg::kWatchdogDivider);
  if (!divider) return tl::unexpected(divider.error());
  const auto time = link.read<std::uint16_t>(s.address, reg::kWatchdogTimeProcessData);
  if (!time) return tl::unexpected(time.error());
  if (*divider != kWatchdogDivider100us || *time != units) return off();
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i) {
    if (!s.sync_managers[i].is(SyncManagerKind::ProcessOut) || s.sync_managers[i].registers.length == 0) continue;
    const auto control = link.read<std::uint8_t>(s.address, sm_register(i, kSmControlOffset));
    if (!control) return tl::unexpected(control.error());
    if ((*control & kSmWatchdogTrigger) == 0) return off();
  }
  return {};
}

}  // namespace

Result<void> write_process_data(Link& link, const StationRecord& s) {
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i)
    if (!s.sync_managers[i].is_mailbox())
      if (auto ok = write_sync_manager(link, s, i); !ok) return ok;
  for (std::size_t i = 0; i < s.fmmus.size(); ++i) {
    const auto raw = to_bytes(s.fmmus[i]);
    if (auto ok = link.write(s.address, static_cast<std::uint16_t>(reg::kFmmu0 + kFmmuBytes * i),
                             std::span<const std::byte>(raw));
        !ok)
      return ok;
  }
  return write_watchdog(link, s);
}

}  // namespace gantry::devices
