// The bytes of one fuzz input, taken from the front; past the end everything reads as zero.
//   Input in(data, size);   in.u8();  in.take(n);  in.rest();
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace gantry::fuzz {

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : left_(reinterpret_cast<const std::byte*>(data), size) {}

  [[nodiscard]] bool empty() const { return left_.empty(); }
  std::uint8_t u8() {
    const auto b = take(1);
    return b.empty() ? std::uint8_t{0} : std::to_integer<std::uint8_t>(b[0]);
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

}  // namespace gantry::fuzz
