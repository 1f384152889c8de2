// What a cyclic frame of the reference machine says, read from its bytes by places counted by hand, so that the judge
// of a stop frame is not the code that makes it.
//   Ethernet header 14, EtherCAT header 2, then datagrams of header 10, data, counter 2 (ETG.1000.4, 5.3.2, 5.4)
//   LRW: a region a station in the order of the ring, its outputs and then its inputs
//        io 2 + 2 bytes, x 9 + 19, y1 9 + 19, y2 9 + 19, z 9 + 19, cu 18 + 38
//   outputs of an axis: 6040h u16, 6060h i8, 607Ah i32, 60B8h u16     (rx_pdos and tx_pdos in config/drives)
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gantry::test {

struct AxisWords {
  std::uint16_t control = 0;
  std::int8_t mode = 0;
  std::int32_t target = 0;
  std::uint16_t probe = 0;
};

struct WireImage {
  std::array<AxisWords, 6> axes{};  ///< x, y1, y2, z, c, u
  std::uint16_t outputs = 0;

  [[nodiscard]] bool all(std::uint16_t control) const {
    return std::all_of(axes.begin(), axes.end(), [&](const AxisWords& a) { return a.control == control; });
  }
  [[nodiscard]] bool any_enabling() const {  // CiA 402: "enable operation" is xxxx x1 1111 in bits 0 to 3
    return std::any_of(axes.begin(), axes.end(), [](const AxisWords& a) { return (a.control & 0x0F) == 0x0F; });
  }
  /// The last word of the reference machine whose drives have torque: Y's quick stop brakes by its manual
  /// (AMD530B 8.4); of the others no manual says so, and they halt at their targets.
  [[nodiscard]] bool is_stop() const {
    constexpr std::array<std::uint16_t, 6> kStops{0x010F, 0x0002, 0x0002, 0x010F, 0x010F, 0x010F};
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (axes[i].control != kStops[i]) return false;
    return true;
  }
  /// Some axis is asked for more than to stand where that stop has left it: it begins to have torque, it homes, or its
  /// target is farther away than one cycle of any axis here. One that was homing stands where it has stopped by itself.
  [[nodiscard]] bool goes_on_after(const WireImage& stop) const {
    constexpr std::int32_t kOneCycle = 500;  // counts
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if ((axes[i].control & 0x0F) != 0x0F) continue;
      const bool stood = stop.axes[i].control == 0x010F;
      const bool by_itself = stop.axes[i].mode == 6;
      const bool elsewhere = !by_itself && std::abs(axes[i].target - stop.axes[i].target) > kOneCycle;
      if (!stood || (axes[i].control & 0x10) != 0 || elsewhere) return true;
    }
    return false;
  }
  /// All outputs but the clamp's, which no stop switches.
  [[nodiscard]] bool rests() const { return (outputs & ~0x40) == 0; }
  [[nodiscard]] bool clamp() const { return (outputs & 0x40) != 0; }
  [[nodiscard]] bool valve() const { return (outputs & 1) != 0; }
  [[nodiscard]] std::string text() const {
    std::string out;
    char word[48];
    for (const AxisWords& a : axes) {
      std::snprintf(word, sizeof word, "[%04X mode %d target %d] ", a.control, a.mode, a.target);
      out += word;
    }
    std::snprintf(word, sizeof word, "outputs %04X", outputs);
    return out + word;
  }
};

constexpr std::size_t kImageBytes = (2 + 2) + 4 * (9 + 19) + (18 + 38);

/// Where the LRW's data begin in the frame; 0 when there is no LRW over the whole image.
inline std::size_t find_lrw(std::span<const std::byte> frame) {
  const auto u8 = [&](std::size_t at) { return std::to_integer<unsigned>(frame[at]); };
  constexpr unsigned kLrw = 12, kMore = 0x80;
  if (frame.size() < 16 || u8(12) != 0x88 || u8(13) != 0xA4) return 0;
  for (std::size_t at = 16; at + 12 <= frame.size();) {
    const std::size_t length = u8(at + 6) | (u8(at + 7) & 0x07) << 8;
    if (u8(at) == kLrw && length == kImageBytes && at + 12 + length <= frame.size()) return at + 10;
    if ((u8(at + 7) & kMore) == 0) return 0;
    at += 12 + length;
  }
  return 0;
}

/// Nothing when it carries no process data.
inline std::optional<WireImage> decode_cyclic(std::span<const std::byte> frame) {
  const std::size_t data = find_lrw(frame);
  if (data == 0) return std::nullopt;
  const auto u8 = [&](std::size_t at) { return std::to_integer<unsigned>(frame[data + at]); };
  const auto u16 = [&](std::size_t at) { return u8(at) | u8(at + 1) << 8; };
  WireImage image;
  constexpr std::array<std::size_t, 6> kAxes{4, 32, 60, 88, 116, 116 + 9};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t at = kAxes[i];
    image.axes[i] = {static_cast<std::uint16_t>(u16(at)), static_cast<std::int8_t>(u8(at + 2)),
                     static_cast<std::int32_t>(u16(at + 3) | u16(at + 5) << 16),
                     static_cast<std::uint16_t>(u16(at + 7))};
  }
  image.outputs = static_cast<std::uint16_t>(u16(0));
  return image;
}

}  // namespace gantry::test
