// The loop's output and input words against the bits of the I/O stations. Names and wiring are the machine file's; here
// are only bits.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "app/cycle/loop_setup.hpp"
#include "devices/bus.hpp"

namespace gantry::cycle {

inline void write_outputs(devices::FieldBus& bus, const LoopSetup& setup, std::uint32_t word) noexcept {
  for (const BitPlace& place : setup.outputs) {
    const std::span<std::byte> image = bus.outputs(place.station);
    if (place.byte >= image.size()) continue;
    const bool on = ((word >> place.word_bit & 1u) != 0) != place.invert;
    const auto mask = static_cast<std::byte>(place.mask);
    image[place.byte] = on ? image[place.byte] | mask : image[place.byte] & ~mask;
  }
}

/// `before`: bits of stations whose inputs are stale stay as they were.
inline std::uint32_t read_inputs(const devices::FieldBus& bus, const LoopSetup& setup, std::uint32_t before) noexcept {
  std::uint32_t word = 0;
  for (const BitPlace& place : setup.inputs) {
    if (!bus.fresh(place.station)) {
      word |= before & 1u << place.word_bit;
      continue;
    }
    const std::span<const std::byte> image = bus.inputs(place.station);
    const bool on =
        place.byte < image.size() && (image[place.byte] & static_cast<std::byte>(place.mask)) != std::byte{0};
    if (on != place.invert) word |= 1u << place.word_bit;
  }
  return word;
}

}  // namespace gantry::cycle
