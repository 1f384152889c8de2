// The bytes of one fuzz input, taken from the front; past the end everything reads as zero. And a hash of what the
// subject says to them, by which driver.cpp sees that an input does the same whatever ran before it.
//   Input in(data, size);   in.u8();  in.take(n);  in.rest();
//   note_said(reply);
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace gantry::fuzz {

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : left_(reinterpret_cast<const std::byte*>(data), size) {}

  [[nodiscard]] bool empty() const { return left_.empty(); }
  std::uint8_t u8() {
    if (left_.empty()) return 0;
    return std::to_integer<std::uint8_t>(take(1)[0]);
  }
  std::uint16_t u16() {
    const unsigned low = u8();
    return static_cast<std::uint16_t>(low | unsigned{u8()} << 8);
  }
  /// At most n bytes.
  std::span<const std::byte> take(std::size_t n) {
    const auto got = left_.first(std::min(n, left_.size()));
    left_ = left_.subspan(got.size());
    return got;
  }
  std::span<const std::byte> rest() { return take(left_.size()); }

 private:
  std::span<const std::byte> left_;
};

inline std::uint64_t said = 0;  ///< of the input that ran last; driver.cpp sets it to 0 before each

inline void note_said(std::uint64_t number) {
  said = (said ^ number) * 0x9E3779B97F4A7C15u;
  said ^= said >> 29;
}
inline void note_said(std::span<const std::byte> bytes) {
  note_said(bytes.size());
  for (; bytes.size() >= 8; bytes = bytes.subspan(8)) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, bytes.data(), 8);
    note_said(eight);
  }
  for (const auto b : bytes) note_said(std::to_integer<std::uint64_t>(b));
}

}  // namespace gantry::fuzz
