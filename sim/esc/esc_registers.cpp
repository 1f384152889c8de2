// Esc: registers 0000h to 0EFFh as the bus reads and writes them, and what a write does.
#include <algorithm>
#include <cstring>

#include "sim/esc/esc.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

struct Range {
  std::size_t from, to;  // [from, to)
};

constexpr bool overlaps(std::size_t at, std::size_t size, std::size_t from, std::size_t length) noexcept {
  return at < from + length && from < at + size;
}

constexpr std::uint16_t kEventMask = 0x0200, kEvents = 0x0210, kStationEvents = 0x0220;
constexpr std::size_t kForwardedErrors = 0x0308, kUnitErrors = 0x030C, kPdiErrors = 0x030D;
constexpr std::uint16_t kDlChanged = 1u << 2, kAlChanged = 1u << 3;  // 0210h
constexpr std::size_t kDcFrom = 0x0900, kDcTo = 0x0A00;

// Registers that the bus may write (ESC data sheet, section II, register overview). Of a SyncManager the status (byte
// 5) and the station's side (byte 7) are not among them, nor what is under way in one that is active.
constexpr std::array kWritable{
    Range{0x0010, 0x0012},                                                // station address
    Range{0x0100, 0x0104},                                                // DL control
    Range{0x0120, 0x0122},                                                // AL control
    Range{0x0200, 0x0202},                                                // event mask
    Range{0x0300, 0x0314},                                                // error counters: a write clears
    Range{0x0400, 0x0402}, Range{0x0410, 0x0412}, Range{0x0420, 0x0422},  // watchdogs
    Range{0x0442, 0x0444},                                                // their counters: a write clears
    Range{0x0600, 0x0680},                                                // FMMU 0..7
    Range{0x0800, 0x0840},                                                // SyncManager 0..7
};
constexpr std::array kWritableDc{
    Range{0x0900, 0x0904}, Range{0x0910, 0x0918}, Range{0x0920, 0x092C}, Range{0x0930, 0x0932},
    Range{0x0934, 0x0936}, Range{0x0980, 0x0982}, Range{0x0990, 0x0998}, Range{0x09A0, 0x09AA},
};

enum : std::uint8_t { kAlways = 1, kWithClock = 2 };
constexpr auto kAccess = [] {
  std::array<std::uint8_t, Esc::kMemoryFrom> table{};
  for (const Range& r : kWritable)
    for (std::size_t i = r.from; i < r.to; ++i) table[i] = kAlways;
  for (const Range& r : kWritableDc)
    for (std::size_t i = r.from; i < r.to; ++i) table[i] = kWithClock;
  for (std::size_t i = reg::kSyncManager0; i < reg::kSyncManager0 + Esc::kSyncManagers * kSyncManagerBytes; ++i)
    if (i % kSyncManagerBytes == kSmStatusOffset || i % kSyncManagerBytes == 7) table[i] = 0;
  return table;
}();

}  // namespace

// --- Reading
// ----------------------------------------------------------------------------------------------------------

bool Esc::read_registers(std::size_t at, std::span<std::byte> out, Time now) noexcept {
  const std::size_t size = out.size();
  const auto hit = [&](std::size_t from, std::size_t length) { return overlaps(at, size, from, length); };
  if (hit(reg::kSiiConfig, SiiUnit::kRegisterBytes))
    sii_.show(std::span(memory_).subspan(reg::kSiiConfig, SiiUnit::kRegisterBytes), now);
  if (hit(kStationEvents, 4)) {
    put<std::uint32_t>(kStationEvents, ((events_ & kAlControl) != 0 ? 1u : 0u) |
                                           ((events_ & kSyncManagersChanged) != 0 ? 1u << 4 : 0u) |
                                           ((events_ & kMailboxWritten) != 0 ? 1u << 8 : 0u));
  }
  if (hit(kDcFrom, kDcTo - kDcFrom)) {
    // Without a clock there are no such registers, and nothing to count (masters look for one that way).
    if (!has_dc() && at >= kDcFrom && at + size <= kDcTo) return false;
    if (has_dc()) show_clock(now);
  }
  std::memcpy(out.data(), memory_.data() + at, size);
  // Reading what an event tells of takes it back.
  if (irq_ != 0 || get<std::uint16_t>(kEvents) != 0) {
    unsigned gone = 0;
    if (hit(reg::kDlStatus, 2)) gone |= kDlChanged;
    if (hit(reg::kAlStatus, 2)) gone |= kAlChanged;
    if (gone != 0) {
      put<std::uint16_t>(kEvents, static_cast<std::uint16_t>(get<std::uint16_t>(kEvents) & ~gone));
      update_irq();
    }
  }
  return true;
}

void Esc::show_clock(Time now) noexcept {
  put<std::uint64_t>(reg::kDcSystemTime, dc_.system(now));
  put<std::uint32_t>(reg::kDcSystemTimeDifference, dc_.difference());
  put<std::uint16_t>(0x0932, dc_.speed_difference());
  if (dc_.sync0_active()) put<std::uint64_t>(reg::kDcStartTime, dc_.next_sync0_system());
}

std::uint16_t Esc::irq() const noexcept { return irq_; }

void Esc::update_irq() noexcept {
  irq_ = static_cast<std::uint16_t>(get<std::uint16_t>(kEvents) & get<std::uint16_t>(kEventMask));
}

// --- Writing
// ----------------------------------------------------------------------------------------------------------

bool Esc::write_registers(std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  bool any = false;
  if (overlaps(at, in.size(), reg::kSiiConfig, SiiUnit::kRegisterBytes)) {
    const std::size_t from = std::max<std::size_t>(at, reg::kSiiConfig);
    const std::size_t to = std::min<std::size_t>(at + in.size(), reg::kSiiConfig + SiiUnit::kRegisterBytes);
    any = sii_.write(from, in.subspan(from - at, to - from), now);
  }
  const unsigned rights = has_dc() ? kAlways | kWithClock : static_cast<unsigned>(kAlways);
  bool changed = false;
  for (std::size_t i = 0; i < in.size(); ++i) {
    const std::size_t byte = at + i;
    if ((kAccess[byte] & rights) == 0) continue;
    if (byte >= reg::kSyncManager0 && byte < reg::kSyncManager0 + kSyncManagers * kSyncManagerBytes &&
        byte % kSyncManagerBytes < kSmStatusOffset &&
        sync_manager_active(static_cast<int>((byte - reg::kSyncManager0) / kSyncManagerBytes)))
      continue;  // where it lies changes only while it is off
    if (dc_.sync0_active() && byte >= reg::kDcStartTime && byte < reg::kDcStartTime + 8u) continue;
    memory_[byte] = in[i];
    changed = true;
  }
  if (changed) on_register_write(at, in.size(), now);
  return any || changed;
}

void Esc::on_register_write(std::size_t at, std::size_t size, Time now) noexcept {
  if (at >= kDcFrom) return on_clock_write(at, size, now);
  const auto hit = [&](std::size_t from, std::size_t length) { return overlaps(at, size, from, length); };
  const auto clear = [&](std::size_t from, std::size_t length) { std::memset(memory_.data() + from, 0, length); };
  if (hit(reg::kDlControl, 4)) {
    if (hit(reg::kDlControl + 1, 1)) shut_ports_ = 0;  // what closed itself opens again
    update_ports();
    events_ |= kPortsChanged;
  }
  if (hit(reg::kAlControl, 2)) events_ |= kAlControl;
  if (hit(kEventMask, 2)) update_irq();
  // Counters go by groups (data sheet II, 2.6): errors of the ports, of the processing unit, of the PDI, lost links.
  if (hit(reg::kRxErrorCounters, kUnitErrors - reg::kRxErrorCounters))
    clear(reg::kRxErrorCounters, kUnitErrors - reg::kRxErrorCounters);
  if (hit(kUnitErrors, 1)) clear(kUnitErrors, 1);
  if (hit(kPdiErrors, 1)) clear(kPdiErrors, 1);
  if (hit(0x030E, 2)) clear(0x030E, 2);
  if (hit(reg::kLostLinkCounters, kPorts)) clear(reg::kLostLinkCounters, kPorts);
  if (hit(reg::kWatchdogCounterProcessData, 2)) clear(reg::kWatchdogCounterProcessData, 2);
  if (hit(reg::kWatchdogDivider, 2) || hit(reg::kWatchdogTimeProcessData, 2)) update_watchdog_limit();
  if (hit(reg::kFmmu0, kFmmus * kFmmuBytes)) reload_fmmus();
  if (hit(reg::kSyncManager0, kSyncManagers * kSyncManagerBytes)) reload_sync_managers(at, size);
  if (at + size > kDcFrom) on_clock_write(at, size, now);
}

void Esc::on_clock_write(std::size_t at, std::size_t size, Time now) noexcept {
  if (!has_dc()) return;
  const auto hit = [&](std::size_t from, std::size_t length) { return overlaps(at, size, from, length); };
  if (hit(reg::kDcSystemTime, 8)) {
    const bool all = at <= reg::kDcSystemTime && at + size >= reg::kDcSystemTime + 8u;
    if (all)
      dc_.receive(get<std::uint64_t>(reg::kDcSystemTime), 64, now);
    else
      dc_.receive(get<std::uint32_t>(reg::kDcSystemTime), 32, now);
    if (at >= reg::kDcSystemTime && at + size <= reg::kDcSystemTime + 8u) return;  // every cycle: nothing else
  }
  if (hit(reg::kDcReceiveTimePort0, 1)) latch_receive_times(now);
  if (hit(reg::kDcSystemTimeOffset, 8)) dc_.set_offset(get<std::uint64_t>(reg::kDcSystemTimeOffset), now);
  if (hit(reg::kDcSystemTimeDelay, 4)) dc_.set_delay(get<std::uint32_t>(reg::kDcSystemTimeDelay));
  if (hit(reg::kDcSpeedCounterStart, 2)) dc_.reset_filter(now);
  if (hit(reg::kDcActivation, 1)) {
    const auto activation = get<std::uint8_t>(reg::kDcActivation);
    const bool wanted = (activation & kDcActivateCyclic) != 0 && (activation & kDcActivateSync0) != 0;
    if (wanted && !dc_.sync0_active())
      dc_.start_sync0(get<std::uint64_t>(reg::kDcStartTime), get<std::uint32_t>(reg::kDcSync0Cycle), now);
    if (!wanted) dc_.stop_sync0();
    dc_.set_sync1_alone((activation & kDcActivateCyclic) != 0 && (activation & kDcActivateSync1) != 0 && !wanted);
    events_ |= kSync0Changed;
  }
}

void Esc::latch_receive_times(Time now) noexcept {
  for (int port = 0; port < kPorts; ++port)
    if (port == 0 || port_open(port))
      put<std::uint32_t>(reg::kDcReceiveTimePort0 + 4u * static_cast<unsigned>(port),
                         static_cast<std::uint32_t>(dc_.latch(now + port_times_[static_cast<std::size_t>(port)])));
  put<std::uint64_t>(reg::kDcReceiveTimeUnit, dc_.latch(now));
}

// --- Ports
// ------------------------------------------------------------------------------------------------------------

void Esc::set_link(int port, bool up) noexcept {
  const unsigned bit = 1u << port;
  if (((links_ & bit) != 0) == up) return;
  links_ ^= bit;
  if (!up) {
    const auto at = reg::kLostLinkCounters + static_cast<std::size_t>(port);
    const auto lost = get<std::uint8_t>(at);
    if (lost < 255) put<std::uint8_t>(at, static_cast<std::uint8_t>(lost + 1));
    // "Auto close": a port that lost its link stays closed until the loop control is written.
    if ((get<std::uint8_t>(reg::kDlControl + 1) >> (2 * port) & 3) == 1) shut_ports_ |= bit;
  }
  put<std::uint16_t>(kEvents, static_cast<std::uint16_t>(get<std::uint16_t>(kEvents) | kDlChanged));
  update_irq();
  update_ports();
}

/// 0110h: 0 station's side ready, 1 its watchdog, 4..7 link of each port, then loop closed and communication by port.
void Esc::update_ports() noexcept {
  const auto control = get<std::uint8_t>(reg::kDlControl + 1);
  unsigned status = (sii_.loaded() ? 1u : 0u) | 2u;
  open_ports_ = 0;
  for (int port = 0; port < kPorts; ++port) {
    const bool up = link(port);
    bool open = false;
    switch (control >> (2 * port) & 3) {
      case 0: open = up; break;
      case 1: open = up && (shut_ports_ >> port & 1) == 0; break;
      case 2: open = (ports_ >> port & 1) != 0; break;
      default: break;
    }
    if (open) open_ports_ |= 1u << port;
    if (up) status |= 1u << (4 + port);
    if (!open) status |= 1u << (8 + 2 * port);
    if (open && up) status |= 1u << (9 + 2 * port);
  }
  put<std::uint16_t>(reg::kDlStatus, static_cast<std::uint16_t>(status));
}

void Esc::count_error(FrameError error, int port) noexcept {
  const auto n = static_cast<std::size_t>(port);
  const std::size_t at = error == FrameError::Invalid     ? reg::kRxErrorCounters + 2 * n
                         : error == FrameError::Receive   ? reg::kRxErrorCounters + 2 * n + 1
                         : error == FrameError::Forwarded ? kForwardedErrors + n
                                                          : kUnitErrors;
  const auto count = get<std::uint8_t>(at);
  if (count < 255) put<std::uint8_t>(at, static_cast<std::uint8_t>(count + 1));
}

}  // namespace gantry::sim
