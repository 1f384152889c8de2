#include "sim/esc/esc.hpp"

#include <algorithm>
#include <utility>

#include "devices/wire/sii.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

constexpr std::uint8_t kTypeEt1100 = 0x11;
constexpr std::uint32_t kDlControlAtStart = 0x0007'0001;  // foreign frames are destroyed, all loops automatic
constexpr std::uint16_t kPowerOnValues = 0x0E00;
constexpr std::uint16_t kWatchdog100ms = 1000;     // 0410h and 0420h, units of 100 us
constexpr std::uint16_t kFeaturesEt1100 = 0x00F0;  // 0008h: low jitter, link detection, FCS errors apart

/// 0E00h: which ports there are (bits 0 and 1), and that they are MII (one bit each from bit 2 on).
constexpr std::uint16_t power_on_values(unsigned ports) noexcept {
  const unsigned third = ports >> 2 & 1, fourth = ports >> 3 & 1;
  return static_cast<std::uint16_t>((third | fourth << 1) | 0b0011u << 2 | (third | fourth) << 4 |
                                    (third & fourth) << 5);
}

}  // namespace

Esc::Esc(std::vector<std::byte> sii, ClockWidth clock) : clock_(clock), sii_(std::move(sii)) {}

void Esc::power_on(Time now) noexcept {
  memory_.fill(std::byte{0});
  other_side_.fill(std::byte{0});
  sii_.power_on(now);
  put<std::uint8_t>(reg::kType, kTypeEt1100);
  put<std::uint16_t>(reg::kBuild, 2);
  put<std::uint8_t>(reg::kFmmuCount, kFmmus);
  put<std::uint8_t>(reg::kSyncManagerCount, kSyncManagers);
  put<std::uint8_t>(reg::kRamKilobytes, kRamBytes / 1024);
  std::uint8_t descriptor = 0;
  for (unsigned port = 0; port < kPorts; ++port)
    if ((ports_ >> port & 1) != 0) descriptor = static_cast<std::uint8_t>(descriptor | 3u << (2 * port));  // MII
  put<std::uint8_t>(reg::kPortDescriptor, descriptor);
  const unsigned clock = clock_ == ClockWidth::Bits64   ? kFeatureDc | kFeatureDc64
                         : clock_ == ClockWidth::Bits32 ? unsigned{kFeatureDc}
                                                        : 0u;
  put<std::uint16_t>(reg::kFeatures, static_cast<std::uint16_t>(kFeaturesEt1100 | clock));
  // What the ESC loads from its EEPROM (data sheet II, table "ESC configuration area").
  if (sii_.loaded()) {
    put<std::uint16_t>(reg::kStationAlias, sii_.word(sii::kAlias));
    put<std::uint16_t>(0x0140, sii_.word(sii::kPdiControl));  // 0140h and 0141h
    put<std::uint16_t>(0x0150, sii_.word(sii::kPdiConfig));
    put<std::uint16_t>(0x0152, sii_.word(sii::kPdiConfig2));
    if (has_dc()) put<std::uint16_t>(reg::kDcPulseLength, sii_.word(sii::kSyncImpulse));
  }
  put<std::uint16_t>(kPowerOnValues, power_on_values(ports_));
  put<std::uint32_t>(reg::kDlControl, kDlControlAtStart);
  update_addresses();
  put<std::uint16_t>(reg::kAlControl, static_cast<std::uint16_t>(AlState::Init));
  put<std::uint16_t>(reg::kAlStatus, static_cast<std::uint16_t>(AlState::Init));
  put<std::uint16_t>(reg::kWatchdogDivider, kWatchdogDivider100us);
  put<std::uint16_t>(reg::kWatchdogTimePdi, kWatchdog100ms);
  put<std::uint16_t>(reg::kWatchdogTimeProcessData, kWatchdog100ms);
  if (has_dc()) {
    put<std::uint16_t>(reg::kDcSpeedCounterStart, 0x1000);
    put<std::uint8_t>(0x0934, 4);   // filter depth of the difference
    put<std::uint8_t>(0x0935, 12);  // of the speed counter
  }
  fmmus_ = {};
  active_fmmus_ = 0, logical_to_ = 0;
  sync_managers_ = {};
  buffers_ = {};
  active_buffers_ = 0;
  bus_events_ = 0;
  for (int i = 0; i < kSyncManagers; ++i) update_status(i);
  events_ = 0;
  irq_ = 0;
  outputs_written_at_ = kNever;
  update_watchdog_limit();
  reset_written_.reset();
  reset_progress_ = 0;
  update_protection();
  // Without its EEPROM an ESC lets nobody at the process RAM (0110h bit 0).
  reachable_to_ = sii_.loaded() ? kMemoryBytes : std::size_t{reg::kProcessRam};
  links_ = shut_ports_ = 0;
  update_ports();
  dc_.power_on(now, clock_ == ClockWidth::Bits32 ? 32 : 64);
}

void Esc::renew() noexcept {
  sii_.renew();
  dc_ = {};
}

bool Esc::read(std::uint16_t ado, std::span<std::byte> out, Time now) noexcept {
  const std::size_t at = ado;
  if (at >= reachable_to_ || out.empty() || out.size() > reachable_to_ - at) return false;
  if (at >= kMemoryFrom) return read_ram(at, out);
  const std::size_t here = std::min(out.size(), kMemoryFrom - at);
  const bool registers = read_registers(at, out.first(here), now);
  const bool ram = here < out.size() && read_ram(kMemoryFrom, out.subspan(here));
  return registers || ram;
}

bool Esc::write(std::uint16_t ado, std::span<const std::byte> in, Time now) noexcept {
  const std::size_t at = ado;
  if (at >= reachable_to_ || in.empty() || in.size() > reachable_to_ - at) return false;
  if (at < protected_to_) [[unlikely]]
    return write_protected(at, in, now);
  if (at >= kMemoryFrom) return write_ram(at, in, now);
  const std::size_t here = std::min(in.size(), kMemoryFrom - at);
  const bool registers = write_registers(at, in.first(here), now);
  const bool ram = here < in.size() && write_ram(kMemoryFrom, in.subspan(here), now);
  return registers || ram;
}

// --- The station's side
// -----------------------------------------------------------------------------------------------

void Esc::set_al_status(std::uint16_t status, std::uint16_t code) noexcept {
  if (get<std::uint16_t>(reg::kAlStatus) != status) {
    bus_events_ |= kAlChanged;
    update_irq();
  }
  put<std::uint16_t>(reg::kAlStatus, status);
  put<std::uint16_t>(reg::kAlStatusCode, code);
}

void Esc::update_watchdog_limit() noexcept {
  const auto units = get<std::uint16_t>(reg::kWatchdogTimeProcessData);
  const bool triggered = std::any_of(buffers_.begin(), buffers_.end(), [](const Buffer& b) { return b.watched; });
  watchdog_limit_ = kNever;
  if (units == 0) put<std::uint8_t>(reg::kWatchdogStatusProcessData, 1);  // one that is off has not expired
  if (units == 0 || !triggered) return;
  const std::int64_t unit_ns = (get<std::uint16_t>(reg::kWatchdogDivider) + 2) * std::int64_t{40};
  watchdog_limit_ = Time{unit_ns * units};
}

void Esc::expire_watchdog() noexcept {
  outputs_written_at_ = kNever;
  put<std::uint8_t>(reg::kWatchdogStatusProcessData, 0);
  const auto count = get<std::uint8_t>(reg::kWatchdogCounterProcessData);
  if (count < 255) put<std::uint8_t>(reg::kWatchdogCounterProcessData, static_cast<std::uint8_t>(count + 1));
}

void Esc::stop_watchdog() noexcept { outputs_written_at_ = kNever; }

}  // namespace gantry::sim
