// The lowest seam of CAN: frames out and in. SocketCAN and the virtual CAN segment stand behind it.
#pragma once
#include <array>
#include <cstdint>

#include "core/clock.hpp"

namespace gantry::devices {

struct CanFrame {
  std::uint32_t id = 0;   ///< 11 bit
  std::uint8_t size = 0;  ///< 0..8
  std::array<std::uint8_t, 8> data{};
  Time rx_time{};
};

class CanPort {
 public:
  virtual ~CanPort() = default;
  virtual bool send(const CanFrame& frame) noexcept = 0;
  /// False when nothing came until `deadline` (a past deadline only looks).
  virtual bool receive(CanFrame& frame, Time deadline) noexcept = 0;
};

}  // namespace gantry::devices
