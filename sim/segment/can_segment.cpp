#include "sim/segment/can_segment.hpp"

#include <algorithm>

#include "devices/wire/cia301.hpp"

namespace gantry::sim {

namespace cia301 = devices::wire::cia301;

CanSegment::CanSegment(const config::Machine& machine, Clock& clock) : clock_(clock) {
  for (const auto& s : machine.stations)
    if (s.bus == config::BusKind::CanOpen)
      nodes_.push_back({static_cast<std::uint8_t>(s.position & cia301::kNodeMask),
                        static_cast<std::uint8_t>(cia301::NodeState::BootUp), clock.now()});
}

bool CanSegment::send(const devices::CanFrame& frame) noexcept {
  if (frame.id == cia301::kSync) ++syncs_;
  if (frame.id != cia301::kNmt || frame.size < 2) return true;
  for (Node& node : nodes_) {
    if (frame.data[1] != 0 && frame.data[1] != node.id) continue;
    switch (static_cast<cia301::Nmt>(frame.data[0])) {
      case cia301::Nmt::Start: node.state = static_cast<std::uint8_t>(cia301::NodeState::Operational); break;
      case cia301::Nmt::Stop: node.state = static_cast<std::uint8_t>(cia301::NodeState::Stopped); break;
      case cia301::Nmt::PreOperational:
        node.state = static_cast<std::uint8_t>(cia301::NodeState::PreOperational);
        break;
      case cia301::Nmt::ResetNode:
      case cia301::Nmt::ResetCommunication:
        node.state = static_cast<std::uint8_t>(cia301::NodeState::BootUp);
        node.next_heartbeat = clock_.now();
        break;
      default: break;
    }
  }
  return true;
}

bool CanSegment::receive(devices::CanFrame& frame, Time deadline) noexcept {
  const auto first = std::min_element(nodes_.begin(), nodes_.end(),
                                      [](const Node& a, const Node& b) { return a.next_heartbeat < b.next_heartbeat; });
  if (first == nodes_.end() || first->next_heartbeat > std::max(deadline, clock_.now())) {
    clock_.sleep_until(deadline);
    return false;
  }
  clock_.sleep_until(first->next_heartbeat);
  frame = {};
  frame.id = cia301::kHeartbeat + first->id;
  frame.size = 1;
  frame.data[0] = first->state;
  frame.rx_time = first->next_heartbeat;
  if (first->state == static_cast<std::uint8_t>(cia301::NodeState::BootUp))
    first->state = static_cast<std::uint8_t>(cia301::NodeState::PreOperational);
  // Heartbeats that nobody fetched are not kept: a listener that comes late hears the next one.
  first->next_heartbeat = std::max(first->next_heartbeat, clock_.now() - kHeartbeat) + kHeartbeat;
  return true;
}

}  // namespace gantry::sim
