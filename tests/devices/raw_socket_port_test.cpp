// On the loopback interface, where what is sent comes back as it was. Skipped where raw sockets are not allowed.
#include "devices/raw_socket_port.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "devices/rt/frame.hpp"

namespace gantry::devices {
namespace {

std::unique_ptr<RawSocketPort> loopback() {
  auto port = RawSocketPort::open("lo");
  return port && (*port)->link_up(PortIndex::Primary) ? std::move(*port) : nullptr;
}

TEST(RawSocketPort, sends_a_frame_and_receives_it_before_the_deadline) {
  const auto port = loopback();
  if (!port && ::geteuid() != 0) GTEST_SKIP() << "no raw sockets";
  ASSERT_TRUE(port);
  MonotonicClock clock;
  Frame frame;
  frame.start(1);
  frame.add(wire::Command::Brd, wire::physical_address(0, wire::reg::kAlStatus), 2);
  ASSERT_TRUE(port->send(PortIndex::Primary, frame.bytes()));
  std::array<std::byte, kMaxFrameBytes> buffer{};
  const Received got = port->receive(buffer, clock.now() + std::chrono::seconds(5));
  ASSERT_EQ(got.size, frame.bytes().size());
  EXPECT_LE(got.rx_time, clock.now());
  Reply reply;
  EXPECT_EQ(match(frame, std::span<const std::byte>(buffer).first(got.size), reply), Match::Unprocessed);  // R15
}

TEST(RawSocketPort, returns_with_nothing_when_the_deadline_is_past) {
  const auto port = loopback();
  if (!port && ::geteuid() != 0) GTEST_SKIP() << "no raw sockets";
  ASSERT_TRUE(port);
  MonotonicClock clock;
  std::array<std::byte, kMaxFrameBytes> buffer{};
  EXPECT_EQ(port->receive(buffer, Time{0}).size, 0u);
  const Time deadline = clock.now() + milliseconds(5);
  EXPECT_EQ(port->receive(buffer, deadline).size, 0u);
  EXPECT_GE(clock.now(), deadline);
  EXPECT_FALSE(port->send(PortIndex::Secondary, buffer));
}

TEST(RawSocketPort, a_second_owner_is_refused_until_the_first_is_gone) {
  auto first = loopback();
  if (!first && ::geteuid() != 0) GTEST_SKIP() << "no raw sockets";
  ASSERT_TRUE(first);
  const auto second = RawSocketPort::open("lo");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().fault, Fault::SecondOwner);
  first.reset();
  EXPECT_TRUE(RawSocketPort::open("lo"));
}

TEST(RawSocketPort, an_interface_that_is_not_there_is_named) {
  const auto port = RawSocketPort::open("nosuch0");
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().fault, Fault::InterfaceUnusable);
  EXPECT_NE(to_text(port.error()).find("nosuch0"), std::string::npos);
}

}  // namespace
}  // namespace gantry::devices
