// Who is connected to whom: the tree of stations from the port states of each (DL status 0110h), in the order in which
// a frame passes them.
//   auto ports = decode_ports(dl_status, port_descriptor);
//   auto tree = build_tree(all_ports);          // position -> parent and its port
//   auto delays = propagation_delays(tree, all_ports, receive_times, which_have_clocks);
// Pure.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "devices/ethercat/station.hpp"

namespace gantry::devices {

Ports decode_ports(std::uint16_t dl_status, std::uint8_t port_descriptor);

struct TreeNode {
  int parent = -1;       ///< position; -1: the master
  int parent_port = -1;  ///< the parent's port that leads here
  int entry_port = 0;    ///< the port that the frame comes in by
};

/// A frame enters a station by one port, leaves through the open ones in the order 0, 3, 1, 2, comes back in each time,
/// and leaves by its entry. So the stations come in depth-first order. A first station that is entered by another port
/// than 0 is wired the wrong side in; its entry is the first open port. Stations that the ports do not account for
/// hang behind the one before (a port changed during the scan); `sound` is false then.
struct Tree {
  std::vector<TreeNode> nodes;  ///< by position
  bool sound = true;
  bool ring = false;  ///< the last open port leads nowhere that answered: the line closes to the master's second port
};
Tree build_tree(std::span<const Ports> stations);

/// Receive times of one latched frame at the four ports (0900h), ns, wrapping at 2^32.
using PortTimes = std::array<std::uint32_t, wire::kPorts>;

/// How long a frame takes from the reference station to each of the others, ns. `clocks`: which have receive
/// times (others are passed through: their own delay falls to the link before them). The reference is the first that
/// has.
std::vector<std::uint32_t> propagation_delays(const Tree& tree, std::span<const Ports> stations,
                                              std::span<const PortTimes> times, const std::vector<bool>& clocks);

}  // namespace gantry::devices
