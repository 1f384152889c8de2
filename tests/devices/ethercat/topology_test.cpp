// Trees from port states. The judge walks frames through a model of cables and ports and times them.
#include "devices/ethercat/topology.hpp"

#include <gtest/gtest.h>
#include <random>

namespace gantry::devices {
namespace {

/// Stations as a plumber would see them: who hangs at which port, with how long a cable.
struct Model {
  struct Node {
    std::array<int, 4> child{-1, -1, -1, -1};
    std::array<std::uint32_t, 4> cable_ns{};
    std::uint32_t clock_offset = 0;
  };
  std::vector<Node> nodes;
  std::vector<PortTimes> times;
  std::vector<std::uint32_t> arrival;  ///< true time at which the frame comes in by port 0
  std::vector<int> order;

  /// A frame comes in at `now` by port 0; when it leaves again.
  std::uint32_t pass(int n, std::uint32_t now) {
    auto& node = nodes[static_cast<std::size_t>(n)];
    order.push_back(n);
    arrival[static_cast<std::size_t>(n)] = now;
    times[static_cast<std::size_t>(n)][0] = now + node.clock_offset;
    for (const int port : {3, 1, 2}) {
      const auto p = static_cast<std::size_t>(port);
      if (node.child[p] < 0) continue;
      now = pass(node.child[p], now + node.cable_ns[p]) + node.cable_ns[p];
      times[static_cast<std::size_t>(n)][p] = now + node.clock_offset;
    }
    return now;
  }
  void run() {
    times.assign(nodes.size(), {});
    arrival.assign(nodes.size(), 0);
    order.clear();
    pass(0, 1000);
  }
  [[nodiscard]] std::vector<Ports> ports() const {
    std::vector<Ports> all;
    for (const int n : order) {
      Ports p;
      const auto& node = nodes[static_cast<std::size_t>(n)];
      p[0] = {wire::PortKind::Mii, true, true, false};
      for (std::size_t i = 1; i < 4; ++i)
        if (node.child[i] >= 0) p[i] = {wire::PortKind::Mii, true, true, false};
      all.push_back(p);
    }
    return all;
  }
};

Model random_tree(std::mt19937& random, int size) {
  Model m;
  m.nodes.resize(static_cast<std::size_t>(size));
  for (int i = 1; i < size; ++i)
    for (;;) {
      auto& parent = m.nodes[random() % static_cast<unsigned>(i)];
      const std::size_t port = 1 + random() % 3;
      if (parent.child[port] >= 0) continue;
      parent.child[port] = i;
      parent.cable_ns[port] = 200 + static_cast<std::uint32_t>(random() % 800);
      break;
    }
  for (auto& n : m.nodes) n.clock_offset = static_cast<std::uint32_t>(random());  // clocks wrap at 2^32
  m.run();
  return m;
}

TEST(Topology, any_tree_is_found_again_and_its_delays_are_exact) {
  std::mt19937 random(7);
  for (int round = 0; round < 2000; ++round) {
    const Model m = random_tree(random, 1 + static_cast<int>(random() % 40));
    const auto ports = m.ports();
    const Tree tree = build_tree(ports);
    ASSERT_TRUE(tree.sound) << "round " << round;
    ASSERT_FALSE(tree.ring);
    for (std::size_t i = 0; i < m.order.size(); ++i) {
      const int parent = tree.nodes[i].parent;
      if (i == 0) {
        ASSERT_EQ(parent, -1);
        continue;
      }
      const auto& node = m.nodes[static_cast<std::size_t>(m.order[static_cast<std::size_t>(parent)])];
      ASSERT_EQ(node.child[static_cast<std::size_t>(tree.nodes[i].parent_port)], m.order[i]) << "round " << round;
    }
    std::vector<PortTimes> times;
    for (const int n : m.order) times.push_back(m.times[static_cast<std::size_t>(n)]);
    const auto delays = propagation_delays(tree, ports, times, std::vector<bool>(ports.size(), true));
    for (std::size_t i = 0; i < delays.size(); ++i)
      ASSERT_EQ(delays[i], m.arrival[static_cast<std::size_t>(m.order[i])] - m.arrival[0]) << "round " << round;
  }
}

TEST(Topology, a_station_without_a_clock_in_a_line_is_passed_through) {
  Model m;
  m.nodes.resize(3);
  m.nodes[0].child[1] = 1, m.nodes[0].cable_ns[1] = 300;
  m.nodes[1].child[1] = 2, m.nodes[1].cable_ns[1] = 500;
  m.run();
  const auto ports = m.ports();
  const auto delays = propagation_delays(build_tree(ports), ports, m.times, {true, false, true});
  EXPECT_EQ(delays, (std::vector<std::uint32_t>{0, 0, 800}));
}

// DL status words as ET1100s show them: two stations in a line, the second one's port 1 closed.
TEST(Topology, dl_status_words_are_decoded) {
  const Ports first = decode_ports(0x5A37, 0x0F), last = decode_ports(0x5617, 0x0F);
  EXPECT_TRUE(first[0].open() && first[1].open());
  EXPECT_FALSE(first[2].open());
  EXPECT_EQ(first[0].kind, wire::PortKind::Mii);
  EXPECT_EQ(first[2].kind, wire::PortKind::Absent);
  EXPECT_TRUE(first[0].communication && first[1].communication);
  EXPECT_TRUE(last[0].open());
  EXPECT_FALSE(last[1].open());
  const Tree tree = build_tree(std::vector{first, last});
  EXPECT_EQ(tree.nodes[1].parent, 0);
  EXPECT_EQ(tree.nodes[1].parent_port, 1);
  EXPECT_TRUE(tree.sound);
}

TEST(Topology, a_ring_and_ports_that_do_not_add_up_are_told) {
  Ports open{};
  for (std::size_t i : {0u, 1u}) open[i] = {wire::PortKind::Mii, true, true, false};
  EXPECT_TRUE(build_tree(std::vector{open, open}).ring);
  Ports end{};
  end[0] = open[0];
  EXPECT_FALSE(build_tree(std::vector{end, end}).sound);
}

}  // namespace
}  // namespace gantry::devices
