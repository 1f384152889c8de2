// Alterations of a station's EEPROM (ETG.2010) as it stands on the simulated side.
//   habits.eeprom = eeprom::without(41);      // no SyncManagers
#pragma once
#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <utility>
#include <vector>

namespace gantry::test::eeprom {

using Image = std::vector<std::byte>;

/// Where a category stands and its bytes, the header included; 0 and 0: there is none.
inline std::pair<std::size_t, std::size_t> category(const Image& image, int type) {
  const auto word = [&](std::size_t at) {
    return std::to_integer<int>(image[at]) | std::to_integer<int>(image[at + 1]) << 8;
  };
  for (std::size_t at = 0x80; at + 4 <= image.size() && word(at) != 0xFFFF;) {
    const std::size_t size = 4 + 2 * static_cast<std::size_t>(word(at + 2));
    if (word(at) == type) return {at, size};
    at += size;
  }
  return {0, 0};
}

inline auto without(int type) {
  return [type](Image& image) {
    const auto [at, size] = category(image, type);
    const auto from = image.begin() + static_cast<std::ptrdiff_t>(at);
    image.erase(from, from + static_cast<std::ptrdiff_t>(size));
  };
}

/// Blank from this byte on.
inline auto cut_at(std::size_t from) {
  return [from](Image& image) {
    std::fill(image.begin() + static_cast<std::ptrdiff_t>(from), image.end(), std::byte{0xFF});
  };
}

inline auto with_byte(std::size_t at, int changed_bits) {
  return [=](Image& image) { image[at] ^= static_cast<std::byte>(changed_bits); };
}

/// A byte of a SyncManager's row: 0 and 1 its start, 2 and 3 its length, 7 its type.
inline auto sync_manager(int number, std::size_t byte, int value) {
  return [=](Image& image) {
    image[category(image, 41).first + 4 + 8 * static_cast<std::size_t>(number) + byte] = static_cast<std::byte>(value);
  };
}

/// The last category first.
inline void turned(Image& image) {
  Image out(image.begin(), image.begin() + 0x80);
  for (const int type : {60, 51, 50, 41, 40, 30, 10}) {
    const auto [at, size] = category(image, type);
    const auto from = image.begin() + static_cast<std::ptrdiff_t>(at);
    out.insert(out.end(), from, from + static_cast<std::ptrdiff_t>(size));
  }
  out.resize(image.size(), std::byte{0xFF});
  image = out;
}

}  // namespace gantry::test::eeprom
