// The CANopen bus in the loop: each tick sends SYNC and takes the frames that have come in, so that the feeder runs by
// the same clock as everything else. What the frames say (PDOs, heartbeat, 6039h guard) comes with the feeder.
//   CanopenCyclic can;
//   const CanTick t = can.tick(port, now);
// Lives in the RT loop.
#pragma once
#include <cstdint>

#include "core/fault.hpp"
#include "devices/can_port.hpp"

namespace gantry::devices {

struct CanTick {
  Fault fault = Fault::None;  ///< CanBusDown when SYNC could not be sent for kSendFailuresMax ticks in a row (R21)
  int received = 0;
};

class CanopenCyclic {
 public:
  static constexpr int kSendFailuresMax = 50;
  static constexpr int kFramesPerTick = 16;  ///< a 1 Mbit/s bus carries at most about 9 frames a millisecond

  CanTick tick(CanPort& port, Time now) noexcept;
  [[nodiscard]] std::uint64_t received() const noexcept { return received_; }

 private:
  int failures_ = 0;
  std::uint64_t received_ = 0;
};

}  // namespace gantry::devices
