// Little-endian values in byte spans, the order of everything EtherCAT and CANopen carry. Offsets are the caller's
// promise: they are checked where the bytes come in, not at every access.
//   put_le<std::uint16_t>(frame, 12, 0x88A4);   auto state = get_le<std::uint16_t>(data, 0);
#pragma once
#include <bit>
#include <cassert>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace gantry::devices::wire {

template <std::integral T>
constexpr T get_le(std::span<const std::byte> bytes, std::size_t offset) noexcept {
  assert(offset + sizeof(T) <= bytes.size());
  using U = std::make_unsigned_t<T>;
  U value = 0;
  if (!std::is_constant_evaluated() && std::endian::native == std::endian::little) {
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
  } else {
    for (std::size_t i = 0; i < sizeof(T); ++i)
      value = static_cast<U>(value | static_cast<U>(std::to_integer<U>(bytes[offset + i]) << (8 * i)));
  }
  return static_cast<T>(value);
}

template <std::integral T>
constexpr void put_le(std::span<std::byte> bytes, std::size_t offset, std::type_identity_t<T> value) noexcept {
  assert(offset + sizeof(T) <= bytes.size());
  using U = std::make_unsigned_t<T>;
  const auto raw = static_cast<U>(value);
  if (!std::is_constant_evaluated() && std::endian::native == std::endian::little) {
    std::memcpy(bytes.data() + offset, &raw, sizeof(T));
  } else {
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes[offset + i] = static_cast<std::byte>((raw >> (8 * i)) & 0xFF);
  }
}

}  // namespace gantry::devices::wire
