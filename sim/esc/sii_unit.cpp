#include "sim/esc/sii_unit.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "devices/wire/ethercat.hpp"
#include "devices/wire/sii.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

constexpr std::size_t kFrom = reg::kSiiConfig;
constexpr std::size_t kConfigAt = 0, kPdiAccessAt = 1, kControlAt = reg::kSiiControl - kFrom,
                      kAddressAt = reg::kSiiAddress - kFrom, kDataAt = reg::kSiiData - kFrom;
constexpr std::uint8_t kOwnedByStation = 0x01, kTakeAway = 0x02;  // 0500h
constexpr std::uint16_t kCommandBits = kSiiRead | kSiiWrite | kSiiReload;
constexpr std::size_t kConfigArea = 14;  // bytes under the checksum

}  // namespace

SiiUnit::SiiUnit(std::vector<std::byte> image) : image_(std::move(image)), delivered_(image_) {}

void SiiUnit::renew() noexcept {
  std::copy(delivered_.begin(), delivered_.end(), image_.begin());
  running_ = 0;
}

void SiiUnit::power_on(Time now) noexcept {
  settle(now);  // what was under way got through before the supply went
  registers_.fill(std::byte{0});
  running_ = 0;
  done_at_ = kNever;
  load();
}

void SiiUnit::load() noexcept {
  loaded_ = image_.size() > kConfigArea &&
            sii_checksum(std::span(image_).first(kConfigArea)) == std::to_integer<std::uint8_t>(image_[kConfigArea]);
  put_le<std::uint16_t>(registers_, kControlAt,
                        static_cast<std::uint16_t>(kSiiReads8 | (loaded_ ? 0 : kSiiChecksumError | kSiiNotLoaded)));
}

std::uint16_t SiiUnit::word(std::size_t address) const noexcept {
  return 2 * address + 2 <= image_.size() ? get_le<std::uint16_t>(image_, 2 * address) : std::uint16_t{0};
}

bool SiiUnit::write(std::size_t at, std::span<const std::byte> in, Time now) noexcept {
  settle(now);
  const auto owner = [&] { return std::to_integer<std::uint8_t>(registers_[kConfigAt]); };
  bool any = false, control = false;
  for (std::size_t i = 0; i < in.size(); ++i) {
    const std::size_t byte = at + i - kFrom;
    if (byte == kPdiAccessAt) continue;  // the station's
    if (byte == kConfigAt) {
      // Taking it away from the station is a pulse, it does not stay.
      registers_[byte] = in[i] & std::byte{kOwnedByStation};
      if ((in[i] & std::byte{kTakeAway}) != std::byte{0}) registers_[kPdiAccessAt] = std::byte{0};
      any = true;
      continue;
    }
    if (byte >= kDataAt + 2) continue;  // a word is what it writes; the others are read only
    // The bus reaches the rest only while it owns the EEPROM and no command runs.
    if ((owner() & kOwnedByStation) != 0 || running_ != 0) continue;
    any = true;
    if (byte == kControlAt) {
      registers_[byte] = (in[i] & std::byte{kSiiWriteEnable}) | std::byte{kSiiReads8};
      control = true;
    } else if (byte == kControlAt + 1) {
      // Errors go with the next command; bits 3..7 of this byte are not writable.
      registers_[byte] = in[i] & std::byte{kCommandBits >> 8};
      control = true;
    } else {
      registers_[byte] = in[i];
    }
  }
  if (control) command(now);
  return any;
}

void SiiUnit::command(Time now) noexcept {
  const auto control = get_le<std::uint16_t>(registers_, kControlAt);
  const auto wanted = static_cast<std::uint16_t>(control & kCommandBits);
  const auto finish = [&](unsigned errors) {
    put_le<std::uint16_t>(registers_, kControlAt, static_cast<std::uint16_t>(kSiiReads8 | errors));
  };
  const unsigned standing = loaded_ ? 0u : kSiiChecksumError | kSiiNotLoaded;
  if (wanted == 0) return finish(standing);  // clears errors
  if (wanted != kSiiRead && wanted != kSiiWrite && wanted != kSiiReload) return finish(standing | kSiiNoAcknowledge);
  if (wanted == kSiiWrite && (control & kSiiWriteEnable) == 0) return finish(standing | kSiiWriteDenied);
  running_ = wanted;
  done_at_ = now + (wanted == kSiiRead    ? timing_.sii_read
                    : wanted == kSiiWrite ? timing_.sii_write
                                          : timing_.sii_reload);
  put_le<std::uint16_t>(registers_, kControlAt, static_cast<std::uint16_t>(kSiiReads8 | wanted | kSiiBusy));
}

/// What the running command has done by now.
void SiiUnit::settle(Time now) noexcept {
  if (running_ == 0 || now < done_at_) return;
  const auto wanted = std::exchange(running_, std::uint16_t{0});
  done_at_ = kNever;
  const std::size_t at = 2 * static_cast<std::size_t>(get_le<std::uint32_t>(registers_, kAddressAt));
  unsigned errors = loaded_ ? 0u : kSiiChecksumError | kSiiNotLoaded;
  const bool inside = at + 2 <= image_.size();
  if (wanted == kSiiReload) {
    load();
    return;
  }
  if (!inside) {
    errors |= kSiiNoAcknowledge;
  } else if (wanted == kSiiRead) {
    for (std::size_t i = 0; i < 8; ++i)
      registers_[kDataAt + i] = at + i < image_.size() ? image_[at + i] : std::byte{0xFF};
  } else {
    std::memcpy(image_.data() + at, registers_.data() + kDataAt, 2);
  }
  put_le<std::uint16_t>(registers_, kControlAt, static_cast<std::uint16_t>(kSiiReads8 | errors));
}

void SiiUnit::show(std::span<std::byte> registers, Time now) noexcept {
  settle(now);
  std::copy(registers_.begin(), registers_.end(), registers.begin());
}

}  // namespace gantry::sim
