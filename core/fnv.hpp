// FNV-1a, 64 bit (draft-eastlake-fnv): tells contents apart, and is no protection against anybody.
//   Fnv1a hash;   hash.add(byte) ...;   hash.value();
#pragma once
#include <cstdint>

namespace gantry {

class Fnv1a {
 public:
  constexpr void add(std::uint8_t byte) noexcept { value_ = (value_ ^ byte) * 0x100000001b3; }
  [[nodiscard]] constexpr std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;  // offset basis
};

}  // namespace gantry
