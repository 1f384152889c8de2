// Cyclic processing of the segment under the loop's own trap: an allocation or a lock in it aborts this program.
#include <gtest/gtest.h>

#include "core/rt/trap.hpp"
#include "sim/segment/segment.hpp"
#include "sim/station/station.hpp"
#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

TEST(Segment, serves_cyclic_frames_without_an_allocation_or_a_lock) {
  const config::Machine machine = reference();
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  const int n = bus.address_all();
  const std::uint64_t start = segment.station(0).esc().dc().system(clock.now()) + 50'000'000;
  std::uint32_t at = 0;
  for (int i = 0; i < n; ++i) {
    const auto s = static_cast<std::uint16_t>(0x1001 + i);
    const bool io = i == 5;
    const std::size_t bytes_each_way = io ? 2 : i == 4 ? 12 : 6;  // the mapping at power-on
    if (!io) bus.mailboxes(s);
    ASSERT_EQ(bus.request(s, 2), 2);
    bus.sync_manager(s, io ? 0 : 2, io ? 0x0F00 : 0x1100, bytes_each_way, 0x64);
    bus.sync_manager(s, io ? 1 : 3, io ? 0x1000 : 0x1400, bytes_each_way, 0x20);
    bus.fmmu(s, 0, at, bytes_each_way, io ? 0x0F00 : 0x1100, 2);
    bus.fmmu(s, 1, at, bytes_each_way, io ? 0x1000 : 0x1400, 1);
    at += static_cast<std::uint32_t>(bytes_each_way);
    bus.write(s, 0x0990, start, 8);
    bus.write(s, 0x09A0, 1'000'000, 4);
    bus.write(s, 0x0981, 3, 1);
    ASSERT_EQ(bus.request(s, 4), 4);
    bus.write(s, 0x0120, 8, 2);
  }
  const Raw cyclic = RawMaster::frame(RawMaster::datagram(12, 0, 0, Raw(at), true) +
                                      RawMaster::datagram(14, 0x1001, 0x0910, Raw(8), true) +
                                      RawMaster::datagram(7, 0, 0x0130, Raw(2)));
  Raw frame = cyclic;
  for (int i = 0; i < 5000; ++i) {
    bus.wait(milliseconds(1));
    frame = cyclic;
    const std::uint8_t control[] = {0x00, 0x06, 0x07, 0x0F};
    for (std::size_t k = 0; k < 4; ++k) frame[26 + 6 * k] = control[std::min(i / 50, 3)];
    if (i > 300)  // axes in motion
      for (std::size_t k = 0; k < 4; ++k)
        frame[26 + 6 * k + 2] = static_cast<std::uint8_t>(i),
                           frame[26 + 6 * k + 3] = static_cast<std::uint8_t>(i >> 8 & 3);
    const rt::Section loop;
    bus.process(frame);
  }
  EXPECT_EQ(value(frame, 26 + at, 2), 18u);
  EXPECT_EQ(value(frame, 26 + at + 2 + 10 + 8 + 2 + 10, 1), 8u);  // all in OP
}

}  // namespace
}  // namespace gantry::sim::test
