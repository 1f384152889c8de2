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
  for (const ImageBit& at : setup.outputs) {
    const std::span<std::byte> image = bus.outputs(at.station);
    if (at.byte >= image.size()) continue;
    const bool on = ((word >> at.word_bit & 1u) != 0) != at.invert;
    const auto mask = static_cast<std::byte>(at.mask);
    image[at.byte] = on ? image[at.byte] | mask : image[at.byte] & ~mask;
  }
}

/// `before`: bits of stations whose inputs are stale stay as they were.
inline std::uint32_t read_inputs(const devices::FieldBus& bus, const LoopSetup& setup, std::uint32_t before) noexcept {
  std::uint32_t word = 0;
  for (const ImageBit& at : setup.inputs) {
    if (!bus.fresh(at.station)) {
      word |= before & 1u << at.word_bit;
      continue;
    }
    const std::span<const std::byte> image = bus.inputs(at.station);
    const bool on = at.byte < image.size() && (image[at.byte] & static_cast<std::byte>(at.mask)) != std::byte{0};
    if (on != at.invert) word |= 1u << at.word_bit;
  }
  return word;
}

}  // namespace gantry::cycle
