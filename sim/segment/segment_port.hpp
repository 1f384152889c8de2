// The virtual segment in the same process as the master: what is sent comes back after the time that it would spend on
// the wire, many frames in flight; in order unless a script says otherwise.
//   SegmentPort port(segment, clock);   // a devices::FramePort
// On a virtual clock, receive() with nothing on the way lets the time pass to its deadline.
#pragma once
#include <array>

#include "devices/frame_port.hpp"
#include "sim/segment/delay_line.hpp"
#include "sim/segment/segment.hpp"

namespace gantry::sim {

class SegmentPort final : public devices::FramePort {
 public:
  SegmentPort(Segment& segment, Clock& clock) noexcept : segment_(segment), clock_(clock) {}

  bool send(devices::PortIndex port, std::span<const std::byte> frame) noexcept override;
  devices::Received receive(std::span<std::byte> buffer, Time deadline) noexcept override;
  [[nodiscard]] bool link_up(devices::PortIndex port) const noexcept override;

 private:
  Segment& segment_;
  Clock& clock_;
  std::array<std::byte, devices::kMaxFrameBytes> passing_;
  DelayLine back_;
};

}  // namespace gantry::sim
