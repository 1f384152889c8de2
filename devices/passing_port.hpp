// A port that stands in front of another one and passes everything on: the base of those that look at frames or change
// some of them.
//   class Tap final : public PassingPort { using PassingPort::PassingPort;  bool send(...) noexcept override; };
// It has no descriptor: frames that are sent on a socket directly would not pass through it.
#pragma once
#include "devices/frame_port.hpp"

namespace gantry::devices {

class PassingPort : public FramePort {
 public:
  /// `port` outlives it.
  explicit PassingPort(FramePort& port) : port_(port) {}
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override { return port_.send(port, frame); }
  Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    return port_.receive(buffer, deadline);
  }
  void arm(Time deadline) noexcept override { port_.arm(deadline); }
  [[nodiscard]] bool link_up(PortIndex port) const noexcept override { return port_.link_up(port); }

 protected:
  FramePort& port_;
};

}  // namespace gantry::devices
