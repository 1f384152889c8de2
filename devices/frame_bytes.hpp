// A whole Ethernet frame that somebody keeps, without the FCS.
#pragma once
#include <array>
#include <cstddef>
#include <span>

namespace gantry::devices {

inline constexpr std::size_t kMaxFrameBytes = 1514;  ///< Ethernet header and payload, without the FCS

struct FrameBytes {
  std::array<std::byte, kMaxFrameBytes> bytes{};
  std::size_t size = 0;
  [[nodiscard]] std::span<const std::byte> all() const noexcept { return std::span(bytes).first(size); }
};

}  // namespace gantry::devices
