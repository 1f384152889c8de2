#include "sim/esc.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "devices/wire/sii.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

struct Range {
  std::size_t from, to;  // [from, to)
};

constexpr bool overlaps(std::size_t at, std::size_t size, std::size_t from, std::size_t length) noexcept {
  return at < from + length && from < at + size;
}

// Registers that the bus may write (ESC data sheet, section II, register overview). A SyncManager's status (byte 5) and
// the station's side of it (byte 7) are not among them; see writable().
constexpr std::array kWritable{
    Range{0x0010, 0x0012},                                                // station address
    Range{0x0100, 0x0104},                                                // DL control
    Range{0x0120, 0x0122},                                                // AL control
    Range{0x0200, 0x0202},                                                // event mask
    Range{0x0300, 0x0314},                                                // error counters, any write clears
    Range{0x0400, 0x0402}, Range{0x0410, 0x0412}, Range{0x0420, 0x0422},  // watchdogs
    Range{0x0442, 0x0444},                                                // watchdog counters, any write clears
    Range{0x0500, 0x0510},                                                // SII
    Range{0x0600, 0x0680},                                                // FMMU 0..7
    Range{0x0800, 0x0840},                                                // SyncManager 0..7
};
constexpr std::array kWritableDc{
    Range{0x0900, 0x0904}, Range{0x0910, 0x0918}, Range{0x0920, 0x092C}, Range{0x0930, 0x0932}, Range{0x0934, 0x0936},
    Range{0x0980, 0x0982}, Range{0x0982, 0x0984}, Range{0x0990, 0x0998}, Range{0x09A0, 0x09A8},
};

bool writable(std::size_t at, bool dc) noexcept {
  if (at >= reg::kSyncManager0 && at < reg::kSyncManager0 + Esc::kSyncManagers * kSyncManagerBytes) {
    const std::size_t byte = at % kSyncManagerBytes;
    return byte != kSmStatusOffset && byte != 7;
  }
  const auto in = [at](const Range& r) { return at >= r.from && at < r.to; };
  return std::any_of(kWritable.begin(), kWritable.end(), in) ||
         (dc && std::any_of(kWritableDc.begin(), kWritableDc.end(), in));
}

constexpr std::uint8_t kTypeEt1100 = 0x11;
constexpr std::uint8_t kTwoMiiPorts = 0x0F;
constexpr std::uint16_t kWatchdog100ms = 1000;  // power-on value of 0410h and 0420h, units of 100 us
constexpr std::size_t kSiiControlAt = reg::kSiiControl, kSm0 = reg::kSyncManager0;

bool is_mailbox(const SyncManager& sm) noexcept { return (sm.control & 0x03) == kSmMailboxMode; }
bool bus_writes(const SyncManager& sm) noexcept { return (sm.control & 0x0C) == kSmEcatWrites; }

}  // namespace

Esc::Esc(std::vector<std::byte> sii, bool dc) : sii_(std::move(sii)), has_dc_(dc) {}

void Esc::power_on(Time now) noexcept {
  memory_.fill(std::byte{0});
  put<std::uint8_t>(reg::kType, kTypeEt1100);
  put<std::uint16_t>(reg::kBuild, 2);
  put<std::uint8_t>(reg::kFmmuCount, kFmmus);
  put<std::uint8_t>(reg::kSyncManagerCount, kSyncManagers);
  put<std::uint8_t>(reg::kRamKilobytes, kRamBytes / 1024);
  put<std::uint8_t>(reg::kPortDescriptor, kTwoMiiPorts);
  put<std::uint16_t>(reg::kFeatures, has_dc_ ? kFeatureDc | kFeatureDc64 : 0);
  if (sii_.size() >= 2u * sii::kAlias + 2u)
    put<std::uint16_t>(reg::kStationAlias, get_le<std::uint16_t>(sii_, 2u * sii::kAlias));
  put<std::uint16_t>(reg::kAlControl, static_cast<std::uint16_t>(AlState::Init));
  put<std::uint16_t>(reg::kAlStatus, static_cast<std::uint16_t>(AlState::Init));
  put<std::uint16_t>(reg::kWatchdogDivider, kWatchdogDivider100us);
  put<std::uint16_t>(reg::kWatchdogTimePdi, kWatchdog100ms);
  put<std::uint16_t>(reg::kWatchdogTimeProcessData, kWatchdog100ms);
  put<std::uint16_t>(reg::kSiiControl, kSiiReads8);
  put<std::uint16_t>(reg::kDcSpeedCounterStart, 0x1000);
  fmmus_ = {};
  sync_managers_ = {};
  mailbox_open_ = {};
  events_ = 0;
  outputs_written_at_ = kNever;
  dc_.power_on(now);
  set_links(false, false, Time{0});
}

void Esc::set_links(bool port0, bool port1, Time turnaround) noexcept {
  // 0110h: 0 station's side ready, 4..7 link of each port, 8/9 loop closed and communication of port 0, 10/11 of 1 ...
  std::uint16_t status = 0x0001 | 1u << 12 | 1u << 14;  // ports 2 and 3 do not exist: closed
  const auto before = get<std::uint16_t>(reg::kDlStatus);
  for (const auto& [port, up] : {std::pair{0, port0}, std::pair{1, port1}}) {
    const auto at = reg::kLostLinkCounters + static_cast<std::size_t>(port);
    const auto lost = get<std::uint8_t>(at);
    if (dl_link(before, port) && !up && lost < 255) put<std::uint8_t>(at, static_cast<std::uint8_t>(lost + 1));
  }
  status = static_cast<std::uint16_t>(status | (port0 ? 1u << 4 | 1u << 9 : 1u << 8));
  status = static_cast<std::uint16_t>(status | (port1 ? 1u << 5 | 1u << 11 : 1u << 10));
  put<std::uint16_t>(reg::kDlStatus, status);
  port1_open_ = port1;
  turnaround_ = turnaround;
}

bool Esc::answers_to(std::uint16_t address) const noexcept {
  const bool alias_enabled = (get<std::uint8_t>(reg::kDlControl + 3) & 1) != 0;
  return get<std::uint16_t>(reg::kStationAddress) == address ||
         (alias_enabled && get<std::uint16_t>(reg::kStationAlias) == address);
}

// --- Reading and writing
// ----------------------------------------------------------------------------------------------

bool Esc::read(std::uint16_t ado, std::span<std::byte> out, Time now) noexcept {
  const std::size_t at = ado;
  if (out.empty() || out.size() > memory_.size() || at > memory_.size() - out.size()) return false;
  if (at < kMemoryFrom) refresh_registers(at, out.size(), now);
  if (at + out.size() > kMemoryFrom && !read_ram(at, out.size())) return false;
  std::memcpy(out.data(), memory_.data() + at, out.size());
  // The last byte of a send mailbox empties it; after the copy.
  if (at + out.size() > kMemoryFrom) {
    for (int i = 0; i < kSyncManagers; ++i) {
      const auto& sm = sync_manager(i);
      if (!sync_manager_active(i) || !is_mailbox(sm) || sm.length == 0) continue;
      if (!overlaps(at, out.size(), sm.start, sm.length)) continue;
      mailbox_open_[static_cast<std::size_t>(i)] = true;
      if (at + out.size() >= static_cast<std::size_t>(sm.start) + sm.length) {
        set_mailbox_full(i, false);
        events_ |= kMailboxRead;
      }
    }
  }
  return true;
}

/// Whether the SyncManagers let the bus read here.
bool Esc::read_ram(std::size_t at, std::size_t size) noexcept {
  for (int i = 0; i < kSyncManagers; ++i) {
    const auto& sm = sync_manager(i);
    if (!sync_manager_active(i) || !overlaps(at, size, sm.start, sm.length)) continue;
    if (bus_writes(sm)) return false;
    if (!is_mailbox(sm)) continue;
    if (!mailbox_full(i)) return false;
    if (at > sm.start && !mailbox_open_[static_cast<std::size_t>(i)]) return false;
  }
  return true;
}

bool Esc::write(std::uint16_t ado, std::span<const std::byte> in, Time now) noexcept {
  const std::size_t at = ado;
  if (in.empty() || in.size() > memory_.size() || at > memory_.size() - in.size()) return false;
  bool done = false;
  if (at < kMemoryFrom) {
    const std::size_t here = std::min(in.size(), kMemoryFrom - at);
    done = write_registers(at, in.first(here), now);
    if (here < in.size()) done = write_ram(kMemoryFrom, in.subspan(here), now) || done;
    return done;
  }
  return write_ram(at, in, now);
}

bool Esc::write_ram(std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  for (int i = 0; i < kSyncManagers; ++i) {
    const auto& sm = sync_manager(i);
    if (!sync_manager_active(i) || !overlaps(at, in.size(), sm.start, sm.length)) continue;
    if (!bus_writes(sm)) return false;
    if (!is_mailbox(sm)) continue;
    if (mailbox_full(i)) return false;
    if (at > sm.start && !mailbox_open_[static_cast<std::size_t>(i)]) return false;
  }
  std::memcpy(memory_.data() + at, in.data(), in.size());
  for (int i = 0; i < kSyncManagers; ++i) {
    const auto& sm = sync_manager(i);
    if (!sync_manager_active(i) || !overlaps(at, in.size(), sm.start, sm.length)) continue;
    const bool last_byte = at + in.size() >= static_cast<std::size_t>(sm.start) + sm.length;
    if (is_mailbox(sm)) {
      mailbox_open_[static_cast<std::size_t>(i)] = true;
      if (last_byte) {
        set_mailbox_full(i, true);
        events_ |= kMailboxWritten;
      }
    } else if (last_byte) {
      outputs_written_at_ = now;
      put<std::uint8_t>(reg::kWatchdogStatusProcessData, 1);
      events_ |= kOutputsWritten;
    }
  }
  return true;
}

void Esc::refresh_registers(std::size_t at, std::size_t size, Time now) noexcept {
  if (!has_dc_ || !overlaps(at, size, reg::kDcReceiveTimePort0, 0x30)) return;
  put<std::uint64_t>(reg::kDcSystemTime, dc_.system(now));
  put<std::uint32_t>(reg::kDcSystemTimeDifference, dc_.difference());
}

bool Esc::write_registers(std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (!writable(at + i, has_dc_)) continue;
    memory_[at + i] = in[i];
    any = true;
  }
  if (any) on_register_write(at, in.size(), now);
  return any;
}

void Esc::on_register_write(std::size_t at, std::size_t size, Time now) noexcept {
  const auto hit = [&](std::size_t from, std::size_t length) { return overlaps(at, size, from, length); };
  if (hit(reg::kAlControl, 2)) events_ |= kAlControl;
  if (hit(reg::kRxErrorCounters, 0x14)) std::memset(memory_.data() + reg::kRxErrorCounters, 0, 0x14);
  if (hit(reg::kWatchdogCounterProcessData, 2)) put<std::uint16_t>(reg::kWatchdogCounterProcessData, 0);
  if (hit(kSiiControlAt, 2)) run_sii_command();
  if (hit(reg::kFmmu0, kFmmus * kFmmuBytes)) reload_fmmus();
  if (hit(kSm0, kSyncManagers * kSyncManagerBytes)) reload_sync_managers();
  if (!has_dc_ || at + size <= reg::kDcReceiveTimePort0) return;

  if (hit(reg::kDcReceiveTimePort0, 4)) {
    put<std::uint32_t>(reg::kDcReceiveTimePort0, static_cast<std::uint32_t>(dc_.local(now)));
    if (port1_open_)
      put<std::uint32_t>(reg::kDcReceiveTimePort0 + 4, static_cast<std::uint32_t>(dc_.local(now + turnaround_)));
    put<std::uint64_t>(reg::kDcReceiveTimeUnit, dc_.local(now));
  }
  if (hit(reg::kDcSystemTime, 8)) {
    const bool all = at <= reg::kDcSystemTime && at + size >= reg::kDcSystemTime + 8u;
    if (all)
      dc_.receive(get<std::uint64_t>(reg::kDcSystemTime), 64, now);
    else
      dc_.receive(get<std::uint32_t>(reg::kDcSystemTime), 32, now);
  }
  if (hit(reg::kDcSystemTimeOffset, 8)) dc_.set_offset(get<std::uint64_t>(reg::kDcSystemTimeOffset), now);
  if (hit(reg::kDcSystemTimeDelay, 4)) dc_.set_delay(get<std::uint32_t>(reg::kDcSystemTimeDelay));
  if (hit(reg::kDcSpeedCounterStart, 2)) dc_.reset_filter(now);
  if (hit(reg::kDcActivation, 1)) {
    const auto activation = get<std::uint8_t>(reg::kDcActivation);
    const bool wanted = (activation & kDcActivateCyclic) != 0 && (activation & kDcActivateSync0) != 0;
    if (wanted && !dc_.sync0_active())
      dc_.start_sync0(get<std::uint64_t>(reg::kDcStartTime), get<std::uint32_t>(reg::kDcSync0Cycle), now);
    if (!wanted) dc_.stop_sync0();
    events_ |= kSync0Changed;
  }
}

// ETG.1000.4, 6.4: command bits 8..10, word address at 0504h, data at 0508h. Busy is over before the next frame.
void Esc::run_sii_command() noexcept {
  const auto control = get<std::uint16_t>(reg::kSiiControl);
  const std::size_t at = 2 * static_cast<std::size_t>(get<std::uint32_t>(reg::kSiiAddress));
  std::uint16_t errors = 0;
  if ((control & kSiiRead) != 0) {
    for (std::size_t i = 0; i < 8; ++i)
      memory_[reg::kSiiData + i] = at + i < sii_.size() ? sii_[at + i] : std::byte{0xFF};
  } else if ((control & kSiiWrite) != 0) {
    if ((control & kSiiWriteEnable) == 0)
      errors = kSiiWriteDenied;
    else if (at + 2 > sii_.size())
      errors = kSiiNoAcknowledge;
    else
      std::memcpy(sii_.data() + at, memory_.data() + reg::kSiiData, 2);
  } else if ((control & kSiiReload) != 0) {
    put<std::uint16_t>(reg::kStationAlias, get_le<std::uint16_t>(sii_, 2u * sii::kAlias));
  }
  put<std::uint16_t>(reg::kSiiControl, static_cast<std::uint16_t>(kSiiReads8 | errors));
}

void Esc::reload_fmmus() noexcept {
  for (std::size_t i = 0; i < fmmus_.size(); ++i)
    fmmus_[i] = get_fmmu(std::span(memory_).subspan(reg::kFmmu0 + i * kFmmuBytes, kFmmuBytes));
}

void Esc::reload_sync_managers() noexcept {
  for (std::size_t i = 0; i < sync_managers_.size(); ++i) {
    const std::size_t at = kSm0 + i * kSyncManagerBytes;
    SyncManager sm = get_sync_manager(std::span(memory_).subspan(at, kSyncManagerBytes));
    const SyncManager& old = sync_managers_[i];
    const bool moved = sm.start != old.start || sm.length != old.length || sm.control != old.control;
    const bool active = (sm.activate & kSmActivateEnable) != 0;
    if (moved || active != ((old.activate & kSmActivateEnable) != 0)) {
      put<std::uint8_t>(at + kSmStatusOffset, 0);
      sm.status = 0;
      mailbox_open_[i] = false;
      events_ |= kSyncManagersChanged;
    }
    if (((sm.activate ^ sm.pdi_control) & kSmActivateRepeatRequest) != 0 && active && is_mailbox(sm))
      events_ |= kMailboxRepeat;
    sync_managers_[i] = sm;
  }
}

// --- Logical addressing
// -----------------------------------------------------------------------------------------------

std::uint16_t Esc::logical(Command command, std::uint32_t address, std::span<std::byte> data, Time now) noexcept {
  bool wrote = false, did_read = false;
  const auto apply = [&](FmmuType type, bool to_station) {
    bool any = false;
    for (const Fmmu& f : fmmus_) {
      if (!f.active || (f.type & static_cast<std::uint8_t>(type)) == 0 || f.length == 0) continue;
      const std::uint64_t end = std::uint64_t{f.logical_start} + f.length;
      if (end <= address || std::uint64_t{address} + data.size() <= f.logical_start) continue;
      const bool whole_bytes = f.logical_start_bit == 0 && f.logical_stop_bit == 7 && f.physical_start_bit == 0;
      any |= whole_bytes ? map_bytes(f, address, data, to_station, now) : map_bits(f, address, data, to_station, now);
    }
    return any;
  };
  if (command != Command::Lrd) wrote = apply(FmmuType::Write, true);
  if (command != Command::Lwr) did_read = apply(FmmuType::Read, false);
  if (command == Command::Lrw)
    return static_cast<std::uint16_t>((did_read ? kWkcReadWriteRead : 0) + (wrote ? kWkcReadWriteWrite : 0));
  return static_cast<std::uint16_t>((did_read ? kWkcRead : 0) + (wrote ? kWkcWrite : 0));
}

bool Esc::map_bytes(const Fmmu& f, std::uint32_t address, std::span<std::byte> data, bool to_station,
                    Time now) noexcept {
  const std::uint64_t from = std::max<std::uint64_t>(address, f.logical_start);
  const std::uint64_t to =
      std::min<std::uint64_t>(std::uint64_t{address} + data.size(), std::uint64_t{f.logical_start} + f.length);
  const auto physical = static_cast<std::uint16_t>(f.physical_start + (from - f.logical_start));
  const auto part = data.subspan(from - address, to - from);
  return to_station ? write(physical, part, now) : read(physical, part, now);
}

bool Esc::map_bits(const Fmmu& f, std::uint32_t address, std::span<std::byte> data, bool to_station,
                   Time now) noexcept {
  const int bits = (f.length - 1) * 8 + (f.logical_stop_bit & 7) - (f.logical_start_bit & 7) + 1;
  bool any = false;
  for (int n = 0; n < bits; ++n) {
    const std::uint64_t logical_bit =
        std::uint64_t{f.logical_start} * 8 + (f.logical_start_bit & 7u) + static_cast<unsigned>(n);
    const std::uint64_t byte = logical_bit / 8;
    if (byte < address || byte >= std::uint64_t{address} + data.size()) continue;
    const unsigned physical_bit = (f.physical_start_bit & 7u) + static_cast<unsigned>(n);
    const std::size_t at = f.physical_start + physical_bit / 8;
    if (at >= memory_.size()) continue;
    std::byte& theirs = data[byte - address];
    const auto their_mask = static_cast<std::byte>(1u << (logical_bit & 7)),
               our_mask = static_cast<std::byte>(1u << (physical_bit & 7));
    if (to_station) {
      const std::byte value = (theirs & their_mask) != std::byte{0} ? memory_[at] | our_mask : memory_[at] & ~our_mask;
      any |= write(static_cast<std::uint16_t>(at), std::span(&value, 1), now);
    } else {
      std::byte value{};
      if (!read(static_cast<std::uint16_t>(at), std::span(&value, 1), now)) continue;
      theirs = (value & our_mask) != std::byte{0} ? theirs | their_mask : theirs & ~their_mask;
      any = true;
    }
  }
  return any;
}

// --- The station's side
// -----------------------------------------------------------------------------------------------

void Esc::set_al_status(std::uint16_t status, std::uint16_t code) noexcept {
  put<std::uint16_t>(reg::kAlStatus, status);
  put<std::uint16_t>(reg::kAlStatusCode, code);
}

std::span<std::byte> Esc::area(int i) noexcept {
  const auto& sm = sync_manager(i);
  if (sm.start < kMemoryFrom || static_cast<std::size_t>(sm.start) + sm.length > memory_.size()) return {};
  return std::span(memory_).subspan(sm.start, sm.length);
}

bool Esc::mailbox_full(int i) const noexcept { return (sync_manager(i).status & kSmStatusMailboxFull) != 0; }

void Esc::set_mailbox_full(int i, bool full) noexcept {
  auto& sm = sync_managers_[static_cast<std::size_t>(i)];
  sm.status = static_cast<std::uint8_t>(full ? sm.status | kSmStatusMailboxFull : sm.status & ~kSmStatusMailboxFull);
  put<std::uint8_t>(kSm0 + static_cast<std::size_t>(i) * kSyncManagerBytes + kSmStatusOffset, sm.status);
  mailbox_open_[static_cast<std::size_t>(i)] = false;
}

void Esc::acknowledge_repeat(int i) noexcept {
  auto& sm = sync_managers_[static_cast<std::size_t>(i)];
  sm.pdi_control =
      static_cast<std::uint8_t>((sm.pdi_control & ~kSmPdiRepeatAck) | (sm.activate & kSmActivateRepeatRequest));
  put<std::uint8_t>(kSm0 + static_cast<std::size_t>(i) * kSyncManagerBytes + 7, sm.pdi_control);
}

Time Esc::watchdog_expires() const noexcept {
  if (outputs_written_at_ == kNever) return kNever;
  const auto units = get<std::uint16_t>(reg::kWatchdogTimeProcessData);
  const bool triggered = std::any_of(sync_managers_.begin(), sync_managers_.end(), [](const SyncManager& sm) {
    return !is_mailbox(sm) && bus_writes(sm) && (sm.control & kSmWatchdogTrigger) != 0 &&
           (sm.activate & kSmActivateEnable) != 0;
  });
  if (units == 0 || !triggered) return kNever;
  const std::int64_t unit_ns = (get<std::uint16_t>(reg::kWatchdogDivider) + 2) * std::int64_t{40};
  return outputs_written_at_ + Time{unit_ns * units};
}

void Esc::expire_watchdog() noexcept {
  outputs_written_at_ = kNever;
  put<std::uint8_t>(reg::kWatchdogStatusProcessData, 0);
  const auto count = get<std::uint8_t>(reg::kWatchdogCounterProcessData);
  if (count < 255) put<std::uint8_t>(reg::kWatchdogCounterProcessData, static_cast<std::uint8_t>(count + 1));
}

void Esc::stop_watchdog() noexcept { outputs_written_at_ = kNever; }

}  // namespace gantry::sim
