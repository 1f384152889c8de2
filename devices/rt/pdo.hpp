// One value of the process image, at the offset that the profile's mapping gave. An object that is not mapped has no
// offset: it reads as the fallback, and writing it does nothing.
//   PdoField<std::uint16_t> controlword{0};   controlword.set(outputs, 0x0F);
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "devices/wire/bytes.hpp"

namespace gantry::devices {

template <class T>
struct PdoField {
  std::int16_t offset = -1;  ///< bytes from the start of the station's inputs or outputs; -1: not mapped

  [[nodiscard]] constexpr bool mapped() const noexcept { return offset >= 0; }
  [[nodiscard]] constexpr T get(std::span<const std::byte> image, T fallback = {}) const noexcept {
    return fits(image.size()) ? wire::get_le<T>(image, static_cast<std::size_t>(offset)) : fallback;
  }
  constexpr void set(std::span<std::byte> image, T value) const noexcept {
    if (fits(image.size())) wire::put_le<T>(image, static_cast<std::size_t>(offset), value);
  }

 private:
  [[nodiscard]] constexpr bool fits(std::size_t size) const noexcept {
    return offset >= 0 && static_cast<std::size_t>(offset) + sizeof(T) <= size;
  }
};

}  // namespace gantry::devices
