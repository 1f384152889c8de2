#include "devices/ethercat/topology.hpp"

#include <algorithm>

namespace gantry::devices {
namespace {

/// Ports in the order in which a frame passes an ESC: in by port 0, then out and in by the others, and out by port 0.
constexpr std::array<int, wire::kPorts> kPortOrder{0, 3, 1, 2};

int order_of(int port) {
  return static_cast<int>(std::find(kPortOrder.begin(), kPortOrder.end(), port) - kPortOrder.begin());
}
int next_port(int port) { return kPortOrder[static_cast<std::size_t>((order_of(port) + 1) % wire::kPorts)]; }

int entry_of(const Ports& ports) {
  for (const int port : kPortOrder)
    if (ports[static_cast<std::size_t>(port)].open()) return port;
  return 0;
}

/// Ports that the frame leaves by, in turn.
std::vector<int> exits_of(const Ports& ports, int entry) {
  std::vector<int> open;
  for (int port = next_port(entry); port != entry; port = next_port(port))
    if (ports[static_cast<std::size_t>(port)].open()) open.push_back(port);
  return open;
}

}  // namespace

Ports decode_ports(std::uint16_t dl_status, std::uint8_t port_descriptor) {
  Ports ports;
  for (int i = 0; i < wire::kPorts; ++i) {
    auto& p = ports[static_cast<std::size_t>(i)];
    p.kind = wire::port_kind(port_descriptor, i);
    p.link = wire::dl_link(dl_status, i);
    p.loop_closed = wire::dl_loop_closed(dl_status, i);
    p.communication = wire::dl_communicates(dl_status, i);
  }
  return ports;
}

Tree build_tree(std::span<const Ports> stations) {
  struct Branch {
    int position;
    std::vector<int> open;
    std::size_t used = 0;
  };
  Tree tree;
  std::vector<Branch> branches;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    TreeNode node;
    node.entry_port = entry_of(stations[i]);
    while (!branches.empty() && branches.back().used == branches.back().open.size()) branches.pop_back();
    if (!branches.empty()) {
      Branch& b = branches.back();
      node.parent = b.position;
      node.parent_port = b.open[b.used++];
    } else if (i > 0) {
      tree.sound = false;
      node.parent = static_cast<int>(i) - 1;
    }
    tree.nodes.push_back(node);
    branches.push_back({static_cast<int>(i), exits_of(stations[i], node.entry_port)});
  }
  std::size_t leading_nowhere = 0;
  for (const Branch& b : branches) leading_nowhere += b.open.size() - b.used;
  tree.ring = leading_nowhere == 1;
  tree.sound = tree.sound && leading_nowhere <= 1;
  return tree;
}

std::vector<std::uint32_t> propagation_delays(const Tree& tree, std::span<const Ports> stations,
                                              std::span<const PortTimes> times, const std::vector<bool>& clocks) {
  const auto at = [&](std::size_t station, int port) { return times[station][static_cast<std::size_t>(port)]; };
  std::vector<std::uint32_t> delays(stations.size(), 0);
  bool have_reference = false;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    if (!clocks[i]) continue;
    if (!have_reference) {
      have_reference = true;
      continue;
    }
    // The nearest station up the tree that has a clock, and its port that leads here.
    int up = tree.nodes[i].parent, port = tree.nodes[i].parent_port;
    while (up >= 0 && !clocks[static_cast<std::size_t>(up)]) {
      port = tree.nodes[static_cast<std::size_t>(up)].parent_port;
      up = tree.nodes[static_cast<std::size_t>(up)].parent;
    }
    if (up < 0 || port < 0) continue;
    const auto p = static_cast<std::size_t>(up);
    const int entry = tree.nodes[p].entry_port;
    int before = entry;
    for (const int out : exits_of(stations[p], entry)) {
      if (out == port) break;
      before = out;
    }
    const std::uint32_t behind = at(p, port) - at(p, before);  // out by this port and back again
    const auto own_exits = exits_of(stations[i], tree.nodes[i].entry_port);
    const std::uint32_t inside = own_exits.empty() ? 0 : at(i, own_exits.back()) - at(i, tree.nodes[i].entry_port);
    const std::uint32_t link = behind > inside ? (behind - inside) / 2 : 0;
    delays[i] = delays[p] + (at(p, before) - at(p, entry)) + link;
  }
  return delays;
}

}  // namespace gantry::devices
