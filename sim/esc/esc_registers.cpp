// Esc: registers 0000h to 0EFFh as the bus reads and writes them, and what a write does.
#include <algorithm>
#include <cstring>

#include "sim/esc/esc.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

constexpr bool overlaps(std::size_t at, std::size_t size, std::size_t from, std::size_t length) noexcept {
  return at < from + length && from < at + size;
}

constexpr std::uint16_t kEventMask = 0x0200, kEvents = 0x0210, kStationEvents = 0x0220;
constexpr std::size_t kForwardedErrors = 0x0308, kUnitErrors = 0x030C, kPdiErrors = 0x030D;
constexpr std::size_t kDcFrom = 0x0900, kDcTo = 0x0A00;
constexpr std::size_t kEscConfiguration = 0x0141;

// What the bus may write (ESC data sheet, section II, columns "ECAT" of an ET1100), and the bits of it that stay:
// reserved ones read 0. Anything else takes nothing and does not count. Nor does what is under way in an active
// SyncManager.
constexpr std::uint8_t kNobody = 0, kAlways = 1, kWithClock = 2;
struct Writable {
  std::uint16_t from, to;  // [from, to)
  std::uint8_t bits = 0xFF;
  std::uint8_t needs = kAlways;
};
constexpr std::array kWritable{
    Writable{0x0010, 0x0012},        // station address
    Writable{0x0020, 0x0022, 0x01},  // register write enable, register write protection
    Writable{0x0030, 0x0032, 0x01},  // ESC write enable, ESC write protection
    Writable{0x0040, 0x0041},        // reset
    Writable{0x0100, 0x0101, 0x03},  // DL control: forwarding rule, temporary loops
    Writable{0x0101, 0x0103},        // DL control: loops, FIFO
    Writable{0x0103, 0x0104, 0x01},  // DL control: alias
    Writable{0x0108, 0x010A},        // physical read/write offset
    Writable{0x0120, 0x0122},        // AL control
    Writable{0x0200, 0x0202},        // event mask
    Writable{0x0300, 0x030E},        // error counters: a write clears
    Writable{0x0310, 0x0314},        // lost links: a write clears
    Writable{0x0400, 0x0402},        // watchdogs
    Writable{0x0410, 0x0412},
    Writable{0x0420, 0x0422},
    Writable{0x0442, 0x0444},                    // their counters: a write clears
    Writable{0x0900, 0x0901, 0xFF, kWithClock},  // a write latches the receive times
    Writable{0x0910, 0x0918, 0xFF, kWithClock},
    Writable{0x0920, 0x092C, 0xFF, kWithClock},
    Writable{0x0930, 0x0932, 0xFF, kWithClock},
    Writable{0x0934, 0x0936, 0x0F, kWithClock},
    Writable{0x0936, 0x0937, 0x01, kWithClock},
    Writable{0x0980, 0x0981, 0x31, kWithClock},
    Writable{0x0981, 0x0982, 0x07, kWithClock},
    Writable{0x0990, 0x0998, 0xFF, kWithClock},
    Writable{0x09A0, 0x09A8, 0xFF, kWithClock},
    Writable{0x09A8, 0x09AA, 0x03, kWithClock},  // latch units
    Writable{0x0F00, 0x0F04},                    // digital outputs
    Writable{0x0F10, 0x0F12},                    // general purpose outputs: 16 of them
};
// The same for each FMMU and each SyncManager.
constexpr std::array<std::uint8_t, kFmmuBytes> kFmmuBits{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x07,
                                                         0x07, 0xFF, 0xFF, 0x07, 0x03, 0x01};
constexpr std::array<std::uint8_t, kSyncManagerBytes> kSyncManagerBits{0xFF, 0xFF, 0xFF, 0xFF, 0x7F, 0x00, 0xC3};

struct Access {
  std::uint8_t rights = 0, bits = 0;
};
constexpr auto kAccess = [] {
  std::array<Access, Esc::kUserRam> table{};
  for (const Writable& w : kWritable)
    for (std::size_t i = w.from; i < w.to; ++i) table[i] = {w.needs, w.bits};
  const auto repeat = [&](std::size_t at, int times, auto&& pattern) {
    for (; times > 0; --times)
      for (const std::uint8_t bits : pattern) table[at++] = {bits != 0 ? kAlways : kNobody, bits};
  };
  repeat(reg::kFmmu0, Esc::kFmmus, kFmmuBits);
  repeat(reg::kSyncManager0, Esc::kSyncManagers, kSyncManagerBits);
  return table;
}();

constexpr std::uint16_t kRegisterEnable = 0x0020, kRegisterProtection = 0x0021, kEscEnable = 0x0030,
                        kEscProtection = 0x0031, kReset = 0x0040;
constexpr std::array<std::uint8_t, 3> kResetSequence{'R', 'E', 'S'};

}  // namespace

// --- Reading
// ----------------------------------------------------------------------------------------------------------

bool Esc::read_registers(std::size_t at, std::span<std::byte> out, Time now) noexcept {
  const std::size_t size = out.size();
  const auto hit = [&](std::size_t from, std::size_t length) { return overlaps(at, size, from, length); };
  if (hit(reg::kSiiConfig, SiiUnit::kRegisterBytes))
    sii_.show(std::span(memory_).subspan(reg::kSiiConfig, SiiUnit::kRegisterBytes), now);
  if (hit(kEvents, 2)) put<std::uint16_t>(kEvents, bus_events_);
  if (hit(reg::kSyncManager0, kSyncManagers * kSyncManagerBytes)) show_sync_managers();
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
  copy_few(out.data(), std::span(memory_).subspan(at, size));
  // Reading what an event tells of takes it back.
  if (bus_events_ != 0) {
    unsigned gone = 0;
    if (hit(reg::kDlStatus, 2)) gone |= kDlChanged;
    if (hit(reg::kAlStatus, 2)) gone |= kAlChanged;
    if ((bus_events_ & gone) != 0) {
      bus_events_ = static_cast<std::uint16_t>(bus_events_ & ~gone);
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

void Esc::update_addresses() noexcept {
  const bool alias_counts = (get<std::uint8_t>(reg::kDlControl + 3) & 1) != 0;
  address_ = get<std::uint16_t>(reg::kStationAddress);
  alias_ = alias_counts ? get<std::uint16_t>(reg::kStationAlias) : address_;
}

void Esc::update_irq() noexcept {
  irq_ = bus_events_ == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(bus_events_ & get<std::uint16_t>(kEventMask));
}

// --- Writing
// ----------------------------------------------------------------------------------------------------------

bool Esc::write_registers(std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  if (at == reg::kDcSystemTime && in.size() == 8 && has_dc()) {  // every station, every cycle
    dc_.receive(get_le<std::uint64_t>(in, 0), 64, now);
    return true;
  }
  bool any = false;
  if (overlaps(at, in.size(), reg::kSiiConfig, SiiUnit::kRegisterBytes)) {
    const std::size_t from = std::max<std::size_t>(at, reg::kSiiConfig);
    const std::size_t to = std::min<std::size_t>(at + in.size(), reg::kSiiConfig + SiiUnit::kRegisterBytes);
    any = sii_.write(from, in.subspan(from - at, to - from), now);
  }
  const unsigned rights = has_dc() ? kAlways | kWithClock : kAlways;
  bool changed = false;
  for (std::size_t i = 0; i < in.size(); ++i) {
    const std::size_t byte = at + i;
    if ((kAccess[byte].rights & rights) == 0) continue;
    if (byte >= reg::kSyncManager0 && byte < reg::kSyncManager0 + kSyncManagers * kSyncManagerBytes &&
        byte % kSyncManagerBytes < kSmStatusOffset &&
        sync_manager_active(static_cast<int>((byte - reg::kSyncManager0) / kSyncManagerBytes)))
      continue;  // where it lies changes only while it is off
    if (dc_.sync0_active() && byte >= reg::kDcStartTime && byte < reg::kDcStartTime + 8u) continue;
    memory_[byte] = in[i] & std::byte{kAccess[byte].bits};
    changed = true;
  }
  if (changed) on_register_write(at, in.size(), now);
  return any || changed;
}

/// Outputs of the ESC itself; what lies between them and the user RAM is reserved or an input.
bool Esc::write_pins(std::size_t at, std::span<const std::byte> in) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (kAccess[at + i].rights == 0) continue;
    memory_[at + i] = in[i];
    any = true;
  }
  return any;
}

// --- Write protection and reset (data sheet II, 2.3)
// ----------------------------------------------------------------------------------------------------------

/// Registers 0000h to 0F7Fh, or all there is, until the register that enables writing was written in the same frame.
void Esc::update_protection() noexcept {
  const auto closed = [&](std::uint16_t protection, std::uint16_t enable) {
    if (get<std::uint8_t>(protection) == 0) put<std::uint8_t>(enable, 0);
    return get<std::uint8_t>(protection) != 0 && get<std::uint8_t>(enable) == 0;
  };
  const bool registers = closed(kRegisterProtection, kRegisterEnable);
  protected_to_ = closed(kEscProtection, kEscEnable) ? kMemoryBytes : registers ? kUserRam : 0;
}

bool Esc::write_protected(std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  const bool all = protected_to_ > kUserRam;
  const auto open = [&](std::size_t byte) {
    return byte == kEscEnable || (!all && (byte == kRegisterEnable || byte >= kUserRam));
  };
  std::size_t i = 0;
  while (i < in.size() && !open(at + i)) ++i;
  if (i == in.size()) return false;
  if (at + i >= kUserRam) return write_ram(at + i, in.subspan(i), now);
  write_registers(at + i, in.subspan(i, 1), now);
  if (i + 1 < in.size()) write(static_cast<std::uint16_t>(at + i + 1), in.subspan(i + 1), now);
  return true;
}

bool Esc::end_frame() noexcept {
  const bool goes_on = reset_written_ && *reset_written_ == kResetSequence[reset_progress_];
  reset_written_.reset();
  reset_progress_ = static_cast<std::uint8_t>(goes_on ? reset_progress_ + 1 : 0);
  if (reset_progress_ == kResetSequence.size()) return true;
  put<std::uint8_t>(kReset, reset_progress_);
  if (reset_progress_ > 0) events_ |= kFrameEnds;  // any frame that does not go on with the sequence ends it
  put<std::uint8_t>(kRegisterEnable, 0);
  put<std::uint8_t>(kEscEnable, 0);
  update_protection();
  return false;
}

void Esc::on_register_write(std::size_t at, std::size_t size, Time now) noexcept {
  if (at >= kDcFrom) return on_clock_write(at, size, now);
  const auto hit = [&](std::size_t from, std::size_t length) { return overlaps(at, size, from, length); };
  const auto clear = [&](std::size_t from, std::size_t length) { std::memset(memory_.data() + from, 0, length); };
  if (at <= kReset) {
    // What is written to the enabling registers does not matter, that it is written does.
    if (hit(kRegisterEnable, 1)) put<std::uint8_t>(kRegisterEnable, 1), events_ |= kFrameEnds;
    if (hit(kEscEnable, 1)) put<std::uint8_t>(kEscEnable, 1), events_ |= kFrameEnds;
    if (hit(kRegisterEnable, 2) || hit(kEscEnable, 2)) update_protection();
    if (hit(kReset, 1)) {
      reset_written_ = get<std::uint8_t>(kReset);
      put<std::uint8_t>(kReset, reset_progress_);
      events_ |= kFrameEnds;
    }
  }
  if (hit(reg::kStationAddress, 2) || hit(reg::kDlControl, 4)) update_addresses();
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
  bus_events_ |= kDlChanged;
  update_irq();
  update_ports();
}

/// 0110h: 0 station's side ready, 1 its watchdog, 4..7 link of each port, then loop closed and communication by port.
void Esc::update_ports() noexcept {
  const auto control = get<std::uint8_t>(reg::kDlControl + 1);
  unsigned status = (sii_.loaded() ? 1u : 0u) | 2u;
  if ((get<std::uint8_t>(kEscConfiguration) & 0xF2) != 0) status |= 4u;  // enhanced link detection, at one port or all
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
