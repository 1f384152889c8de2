// The virtual CAN bus in process. For now it carries one thing: each configured CANopen node boots (boot-up message)
// and then beats its heart; SYNC and everything else is heard and not answered. The node that moves comes with the
// feeder's own issue.
//   CanSegment can(machine, clock);   // a devices::CanPort
#pragma once
#include <array>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "devices/can_port.hpp"

namespace gantry::sim {

class CanSegment final : public devices::CanPort {
 public:
  CanSegment(const config::Machine& machine, Clock& clock);

  bool send(const devices::CanFrame& frame) noexcept override;
  bool receive(devices::CanFrame& frame, Time deadline) noexcept override;

  [[nodiscard]] std::uint64_t syncs() const noexcept { return syncs_; }  ///< SYNC messages heard

 private:
  struct Node {
    std::uint8_t id = 0, state = 0;
    Time next_heartbeat{};
  };
  static constexpr Time kHeartbeat = milliseconds(100);

  Clock& clock_;
  std::vector<Node> nodes_;
  std::uint64_t syncs_ = 0;
};

}  // namespace gantry::sim
