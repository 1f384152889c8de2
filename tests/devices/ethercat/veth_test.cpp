// The same master and the same virtual segment with a real network interface between them: a veth pair in a network
// namespace of the test's own. Skipped where that is not allowed. Nothing here depends on how fast the host is.
#include <atomic>
#include <cstdlib>
#include <gtest/gtest.h>
#include <sched.h>
#include <thread>
#include <unistd.h>

#include "config/machine.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/raw_socket_port.hpp"
#include "sim/segment/segment.hpp"

namespace gantry::devices {
namespace {

bool make_pair() {
  return ::unshare(CLONE_NEWNET) == 0 &&
         std::system(
             "ip link add gantry0 type veth peer name gantry1 && ip link set gantry0 up && "
             "ip link set gantry1 up") == 0;
}

TEST(OverVeth, the_reference_machine_comes_up_through_a_real_interface) {
  const bool made = make_pair();
  if (!made && ::geteuid() != 0) GTEST_SKIP() << "no network namespace of our own";
  ASSERT_TRUE(made);
  const auto machine = config::load_machine(GANTRY_SOURCE_DIR "/config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  auto near_end = RawSocketPort::open("gantry0"), far_end = RawSocketPort::open("gantry1");
  ASSERT_TRUE(near_end && far_end);
  MonotonicClock clock;
  std::atomic<bool> stop{false};
  std::thread ring([&] {
    sim::Segment segment(*machine, clock);
    std::array<std::byte, kMaxFrameBytes> frame{};
    while (!stop) {
      const Received got = (*far_end)->receive(frame, clock.now() + milliseconds(50));
      const auto bytes = std::span(frame).first(got.size);
      if (got.size > 0 && segment.process(bytes)) (*far_end)->send(PortIndex::Primary, bytes);
    }
  });
  EthercatMaster master(*machine, **near_end, clock);
  const auto up = master.bring_up();
  EXPECT_TRUE(up) << to_text(up.error());
  if (up) {
    Exchange e;
    for (int tries = 0; tries < 20 && !e.inputs_fresh; ++tries) e = master.exchange(clock.now() + milliseconds(500));
    EXPECT_TRUE(e.inputs_fresh);
    EXPECT_EQ(e.ethercat.working_counter, e.ethercat.expected);
    EXPECT_EQ(e.ethercat.al_states, 4);
    master.shut_down();
  }
  stop = true;
  ring.join();
}

}  // namespace
}  // namespace gantry::devices
