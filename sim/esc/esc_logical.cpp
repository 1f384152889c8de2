// Esc: logical addressing through the FMMUs (ETG.1000.4, 6.6; ESC data sheet I, chapter 7).
#include <algorithm>

#include "sim/esc/esc.hpp"

namespace gantry::sim {

using namespace devices::wire;

void Esc::reload_fmmus() noexcept {
  active_fmmus_ = 0;
  logical_from_ = ~std::uint64_t{0}, logical_to_ = 0;
  for (std::size_t i = 0; i < fmmus_.size(); ++i) {
    const Fmmu f = get_fmmu(std::span(memory_).subspan(reg::kFmmu0 + i * kFmmuBytes, kFmmuBytes));
    if (!f.active || f.length == 0) continue;
    fmmus_[active_fmmus_++] = f;
    logical_from_ = std::min<std::uint64_t>(logical_from_, f.logical_start);
    logical_to_ = std::max(logical_to_, std::uint64_t{f.logical_start} + f.length);
  }
}

std::uint16_t Esc::logical_here(Command command, std::uint32_t address, std::span<std::byte> data, Time now) noexcept {
  const auto apply = [&](FmmuType type, bool to_station) {
    bool any = false;
    for (const Fmmu& f : std::span(fmmus_).first(active_fmmus_)) {
      if ((f.type & static_cast<std::uint8_t>(type)) == 0) continue;
      const std::uint64_t end = std::uint64_t{f.logical_start} + f.length;
      if (end <= address || std::uint64_t{address} + data.size() <= f.logical_start) continue;
      const bool whole_bytes =
          (f.logical_start_bit & 7) == 0 && (f.logical_stop_bit & 7) == 7 && (f.physical_start_bit & 7) == 0;
      any |= whole_bytes ? map_bytes(f, address, data, to_station, now) : map_bits(f, address, data, to_station, now);
    }
    return any;
  };
  const bool wrote = command != Command::Lrd && apply(FmmuType::Write, true);
  const bool did_read = command != Command::Lwr && apply(FmmuType::Read, false);
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

/// Bits that lie in the datagram, gathered by physical byte: each byte of the station is touched once, as an ESC does,
/// so that a SyncManager under it opens and closes once. Bits of a byte that are not mapped keep their value (assumed:
/// the data sheet promises that for the digital outputs only).
bool Esc::map_bits(const Fmmu& f, std::uint32_t address, std::span<std::byte> data, bool to_station,
                   Time now) noexcept {
  const int bits = (f.length - 1) * 8 + (f.logical_stop_bit & 7) - (f.logical_start_bit & 7) + 1;
  bool any = false;
  for (int n = 0; n < bits;) {
    const unsigned physical_bit = (f.physical_start_bit & 7u) + static_cast<unsigned>(n);
    const std::size_t at = f.physical_start + physical_bit / 8;
    if (at >= memory_.size()) break;
    const int in_byte = std::min<int>(8 - static_cast<int>(physical_bit & 7), bits - n);
    std::byte ours{}, mask{};
    const auto each = [&](auto&& with) {
      for (int k = n; k < n + in_byte; ++k) {
        const std::uint64_t logical_bit =
            std::uint64_t{f.logical_start} * 8 + (f.logical_start_bit & 7u) + static_cast<unsigned>(k);
        const std::uint64_t byte = logical_bit / 8;
        if (byte < address || byte >= std::uint64_t{address} + data.size()) continue;
        with(data[byte - address], static_cast<std::byte>(1u << (logical_bit & 7)),
             static_cast<std::byte>(1u << (((f.physical_start_bit & 7u) + static_cast<unsigned>(k)) & 7)));
      }
    };
    each([&](std::byte theirs, std::byte their_bit, std::byte our_bit) {
      mask |= our_bit;
      if ((theirs & their_bit) != std::byte{0}) ours |= our_bit;
    });
    const auto physical = static_cast<std::uint16_t>(at);
    if (mask != std::byte{0} && to_station) {
      ours |= memory_[at] & ~mask;
      any |= write(physical, std::span(&ours, 1), now);
    } else if (mask != std::byte{0} && read(physical, std::span(&ours, 1), now)) {
      each([&](std::byte& theirs, std::byte their_bit, std::byte our_bit) {
        theirs = (ours & our_bit) != std::byte{0} ? theirs | their_bit : theirs & ~their_bit;
      });
      any = true;
    }
    n += in_byte;
  }
  return any;
}

}  // namespace gantry::sim
