#include "devices/ethercat/bent_image.hpp"

#include <algorithm>

#include "devices/profiles/drive_entries.hpp"

namespace gantry::devices {
namespace {

using config::PdoEntry;
using config::PdoRow;

constexpr std::uint32_t kMostBits = 64;

std::uint64_t get_bits(std::span<const std::byte> image, std::uint32_t at, std::uint32_t bits) noexcept {
  std::uint64_t value = 0;
  for (std::uint32_t i = 0; i < bits;) {
    const std::uint32_t bit = at + i, in_byte = bit % 8, n = std::min(8 - in_byte, bits - i);
    const std::uint64_t part = std::to_integer<std::uint64_t>(image[bit / 8]) >> in_byte & ((1u << n) - 1u);
    value |= part << i;
    i += n;
  }
  return value;
}

void put_bits(std::span<std::byte> image, std::uint32_t at, std::uint32_t bits, std::uint64_t value) noexcept {
  for (std::uint32_t i = 0; i < bits;) {
    const std::uint32_t bit = at + i, in_byte = bit % 8, n = std::min(8 - in_byte, bits - i);
    const auto mask = static_cast<std::byte>(((1u << n) - 1u) << in_byte);
    std::byte& byte = image[bit / 8];
    byte = (byte & ~mask) | (static_cast<std::byte>(value >> i << in_byte & 0xFF) & mask);
    i += n;
  }
}

}  // namespace

BentImage::BentImage(const StationRecord& s, Time cycle)
    : foreign_(s.foreign_outputs), silent_cycles_(kSilentAfter / cycle) {
  const config::StationProfile& profile = s.config->profile;
  const std::vector<PdoRow> loop_out = loop_rows(profile, true), loop_in = loop_rows(profile, false);
  outputs_.resize(image_bytes(loop_out));
  inputs_.resize(image_bytes(loop_in));
  spare_ = outputs_;
  for (const bool outputs : {true, false})
    for (const PdoRow& row : outputs ? loop_out : loop_in)
      for (const PdoEntry& entry : row.entries) {
        const auto here = find_bits(outputs ? loop_out : loop_in, entry.address);
        const auto there = find_bits(outputs ? s.rx_pdos : s.tx_pdos, entry.address);
        const bool left_out = std::ranges::count(s.left_out, entry.address) != 0;
        const bool polled = std::ranges::count(s.slow, entry.address, &SlowObject::address) != 0;
        if (!outputs && entry.address.index != 0 && (!there || left_out) && !polled) absent_.push_back(entry.address);
        if (entry.address.index == 0 || !there || left_out || there->bits > kMostBits) continue;
        const DriveEntry* e = find_drive_entry(config::first_slot(profile, entry.address, row.slot).index);
        const bool has_sign = e != nullptr && e->has_sign;
        if (outputs)
          out_.push_back(copy_of(*here, *there, has_sign));
        else
          in_.push_back(copy_of(*there, *here, has_sign));
      }
  for (const SlowObject& object : s.slow) {
    const auto here = find_bits(object.output ? loop_out : loop_in, object.address);
    SlowValue& value = slow_.emplace_back();
    value.object = object;
    value.bit = here ? static_cast<std::uint32_t>(here->bit) : 0;
  }
}

BentImage::Copy BentImage::copy_of(const MappedBits& from, const MappedBits& to, bool has_sign) {
  return {static_cast<std::uint32_t>(from.bit), static_cast<std::uint32_t>(to.bit),
          static_cast<std::uint8_t>(from.bits), static_cast<std::uint8_t>(to.bits), has_sign};
}

void BentImage::copy(const std::vector<Copy>& copies, std::span<const std::byte> from,
                     std::span<std::byte> to) noexcept {
  for (const Copy& c : copies) {
    std::uint64_t value = get_bits(from, c.from, c.from_bits);
    if (c.has_sign && c.from_bits < kMostBits && (value >> (c.from_bits - 1) & 1) != 0)
      value |= ~std::uint64_t{0} << c.from_bits;
    put_bits(to, c.to, c.to_bits, value);
  }
}

void BentImage::begin_wire(std::span<std::byte> wire) const noexcept {
  for (const ForeignOutput& f : foreign_)
    put_bits(wire, static_cast<std::uint32_t>(f.bit), std::min<std::uint32_t>(f.bits, kMostBits), f.value);
}

void BentImage::to_wire(std::span<std::byte> wire) noexcept {
  copy(out_, outputs_, wire);
  for (SlowValue& v : slow_)
    if (v.object.output)
      v.value.store(static_cast<std::uint32_t>(get_bits(outputs_, v.bit, v.object.bits)), std::memory_order_relaxed);
}

void BentImage::from_wire(std::span<const std::byte> wire, bool fresh) noexcept {
  if (fresh) copy(in_, wire, inputs_);
  for (SlowValue& v : slow_) {
    if (v.object.output) continue;
    put_bits(inputs_, v.bit, v.object.bits, v.value.load(std::memory_order_relaxed));
    const std::uint32_t looks = v.looks.load(std::memory_order_relaxed);
    v.old_cycles = looks == 0 ? silent_cycles_ + 1 : looks != v.looks_seen ? 0 : v.old_cycles + 1;
    v.looks_seen = looks;
  }
}

InputSource BentImage::source(config::ObjectAddress input) const noexcept {
  for (const SlowValue& v : slow_)
    if (!v.object.output && v.object.address == input)
      return v.old_cycles > silent_cycles_ || v.looks_seen == 0 ? InputSource::Silent : InputSource::Polled;
  return std::ranges::count(absent_, input) != 0 ? InputSource::Absent : InputSource::EveryCycle;
}

void BentImage::begin_spare() noexcept { std::ranges::copy(outputs_, spare_.begin()); }
void BentImage::spare_to_wire(std::span<std::byte> wire) const noexcept { copy(out_, spare_, wire); }

}  // namespace gantry::devices
