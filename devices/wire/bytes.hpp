// Little-endian values in byte spans, the order of everything EtherCAT and CANopen carry. Offsets are the caller's
// promise: they are checked where the bytes come in, not at every access.
//   put_le<std::uint16_t>(frame, 12, 0x88A4);   auto state = get_le<std::uint16_t>(data, 0);
#pragma once
#include <array>
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

/// For the few bytes of registers and process data, which are copied many times a cycle: a call costs more than they
/// do. As many as `from` has; the two must not overlap.
inline void copy_few(std::byte* to, std::span<const std::byte> from) noexcept {
  const std::size_t n = from.size();
  const auto ends = [&]<std::size_t size>(std::integral_constant<std::size_t, size>) {  // the two may overlap
    std::array<std::byte, size> first, last;
    std::memcpy(first.data(), from.data(), size);
    std::memcpy(last.data(), from.data() + n - size, size);
    std::memcpy(to, first.data(), size);
    std::memcpy(to + n - size, last.data(), size);
  };
  if (n > 32)
    std::memcpy(to, from.data(), n);
  else if (n >= 16)
    ends(std::integral_constant<std::size_t, 16>{});
  else if (n >= 8)
    ends(std::integral_constant<std::size_t, 8>{});
  else if (n >= 4)
    ends(std::integral_constant<std::size_t, 4>{});
  else
    for (std::size_t i = 0; i < n; ++i) to[i] = from[i];
}

}  // namespace gantry::devices::wire
