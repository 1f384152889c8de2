// What scripts do to the segment, seen from the wire: frames that come late, twice, in another order or not at all,
// branches, clocks that are narrow or shake, stations that lie. Port states and counters by the ESC data sheet.
#include <gtest/gtest.h>
#include <random>

#include "sim/segment/segment.hpp"
#include "sim/segment/segment_port.hpp"
#include "sim/station/station.hpp"
#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

constexpr std::uint16_t kStation = 0x1001;

struct Wire : ::testing::Test {
  config::Machine machine = reference();
  VirtualClock clock;
  Segment segment{machine, clock};
  SegmentPort port{segment, clock};

  void send(std::uint8_t number) {
    Raw f = RawMaster::frame(RawMaster::datagram(7, 0, 0x0000, Raw(1)));
    f[17] = number;  // the datagram's index
    EXPECT_TRUE(port.send(devices::PortIndex::Primary, std::as_bytes(std::span(f))));
  }
  /// Numbers of the frames that come until then, in their order.
  std::vector<int> come(Time until) {
    std::vector<int> numbers;
    std::array<std::byte, devices::kMaxFrameBytes> buffer;
    for (;;) {
      const auto got = port.receive(buffer, until);
      if (got.size == 0) return numbers;
      EXPECT_EQ(std::to_integer<int>(buffer[16 + 11]), 6);  // working counter
      numbers.push_back(std::to_integer<int>(buffer[17]));
    }
  }
};

TEST_F(Wire, frames_come_late_twice_and_in_another_order) {
  segment.faults().duplicate(1);
  send(1);
  EXPECT_EQ(come(clock.now() + milliseconds(1)), (std::vector{1, 1}));
  segment.faults().reorder(1);
  send(2);
  send(3);
  EXPECT_EQ(come(clock.now() + milliseconds(1)), (std::vector{3, 2}));
  segment.faults().delay(1, milliseconds(3));
  send(4);
  EXPECT_EQ(come(clock.now() + milliseconds(1)), (std::vector<int>{}));
  send(5);
  EXPECT_EQ(come(clock.now() + milliseconds(5)), (std::vector{5, 4}));
  segment.faults().corrupt(1);
  send(6);
  send(7);
  EXPECT_EQ(come(clock.now() + milliseconds(1)), (std::vector{7}));
}

TEST_F(Wire, many_frames_are_in_flight) {
  std::vector<int> sent;
  for (int i = 0; i < 40; ++i) send(static_cast<std::uint8_t>(i)), sent.push_back(i);
  EXPECT_EQ(come(clock.now() + milliseconds(20)), sent);
}

TEST_F(Wire, noise_loses_frames_but_changes_none) {
  constexpr std::uint64_t kSeed = 4711;
  LineNoise noise;
  noise.loss = noise.corrupt = noise.duplicate = noise.delay = noise.reorder = 0.02;
  noise.seed = kSeed;
  segment.faults().set_noise(noise);
  RawMaster bus(segment, clock);
  std::mt19937 random(kSeed);
  std::uint32_t held = 0;  // what the station must hold; a frame that was hit has changed nothing
  int lost = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto next = static_cast<std::uint32_t>(random());
    const Answer a = bus.send(3, 0, 0x1800, bytes(next, 4));  // APRW
    if (a.wkc < 0) {
      ++lost;
    } else {
      ASSERT_EQ(a.wkc, 3);
      ASSERT_EQ(value(a.data), held) << "seed " << kSeed << " frame " << i;
      held = next;
    }
  }
  EXPECT_NEAR(lost, 20'000 * 0.0396, 150);
}

TEST_F(Wire, a_branch_shows_in_port_states_and_receive_times) {
  // 0 - 1 - 2 with 3, 4, 5 behind port 2 of 1: frames pass 3, 1, 2 and the positions stay.
  ASSERT_FALSE(segment.hang(StationId{3}, StationId{1}, 3));  // would come before station 2
  ASSERT_TRUE(segment.hang(StationId{3}, StationId{1}, 2));
  RawMaster bus(segment, clock);
  ASSERT_EQ(bus.address_all(), 6);
  EXPECT_EQ(value(bus.read(0x1002, 0x0007, 1).data), 0x3Fu);
  EXPECT_EQ(value(bus.read(0x1002, 0x0110, 2).data), 0x6A73u);  // ports 0, 1, 2 open
  EXPECT_EQ(value(bus.read(0x1003, 0x0110, 2).data), 0x5613u);  // an end
  bus.send(8, 0, 0x0900, Raw(4));
  const auto receive = [&](std::uint16_t s, int p) {
    return static_cast<std::uint32_t>(value(bus.read(s, static_cast<std::uint16_t>(0x0900 + 4 * p), 4).data));
  };
  const std::uint32_t in = receive(0x1002, 0);
  EXPECT_EQ(receive(0x1002, 1) - in, 2u * 620u);                       // station 2, and back
  EXPECT_EQ(receive(0x1002, 2) - receive(0x1002, 1), 2u * 3u * 620u);  // three stations, and back
  segment.cut_link(3);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 3);
  EXPECT_EQ(value(bus.read(0x1002, 0x0110, 2).data), 0x5A33u);
  segment.heal_link(3);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);
}

TEST(NarrowClock, counts_32_bits_and_starts_when_its_counter_comes_round) {
  config::Machine machine = one("drives/amd530b.yaml");
  machine.stations[0].profile.clock_bits = 32;
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  bus.address_all();
  EXPECT_EQ(value(bus.read(kStation, 0x0008, 2).data) & 0x0Cu, 0x04u);
  bus.write(kStation, 0x0920, 0x1234567'0000'0000u, 8);
  EXPECT_EQ(value(bus.read(kStation, 0x0910, 8).data) >> 32, 0u);
  EXPECT_EQ(value(bus.read(kStation, 0x0918, 8).data) >> 32, 0u);
  const auto start = static_cast<std::uint32_t>(value(bus.read(kStation, 0x0910, 4).data)) + 2'000'000u;
  bus.write(kStation, 0x0990, start, 4);
  bus.write(kStation, 0x09A0, 1'000'000, 4);
  bus.write(kStation, 0x0981, 3, 1);
  bus.wait(milliseconds(5));
  segment.advance();
  EXPECT_EQ(segment.station(0).esc().dc().pulses(), 4u);  // at 2, 3, 4 and 5 ms
}

TEST(Jitter, of_a_clock_stays_within_its_bound_and_is_held) {
  config::Machine machine = reference();
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  bus.address_all();
  segment.set_clock_jitter(StationId{3}, 200);
  segment.set_clock_drift(StationId{3}, 80);
  const std::uint16_t s = 0x1004;
  // In step with the reference first, as masters do it.
  const auto mine = value(bus.read(s, 0x0910, 8).data), reference_time = value(bus.read(kStation, 0x0910, 8).data);
  bus.write(s, 0x0920, reference_time - mine, 8);
  std::int64_t worst = 0;
  for (int i = 0; i < 6000; ++i) {
    bus.wait(milliseconds(1));
    bus.send(14, kStation, 0x0910, Raw(8));
    if (i < 3000) continue;
    const auto apart = static_cast<std::int64_t>(segment.station(3).esc().dc().system(clock.now()) -
                                                 segment.station(0).esc().dc().system(clock.now()));
    worst = std::max(worst, std::abs(apart));
  }
  EXPECT_LT(worst, 3000);
  EXPECT_GT(worst, 0);
}

TEST(AnalogueTerminal, carries_words_both_ways) {
  config::Machine machine = one("devices/aio4.yaml", 0);
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  bus.address_all();
  bus.mailboxes(kStation);
  ASSERT_EQ(bus.request(kStation, 2), 2);
  EXPECT_EQ(bus.sdo_read(kStation, 0x1C00, 3), 3u);
  EXPECT_EQ(bus.sdo_read(kStation, 0x1A00, 0), 4u);
  EXPECT_EQ(bus.sdo_read(kStation, 0x1A00, 2), 0x60100110u);
  EXPECT_EQ(bus.sdo_write(kStation, 0x1C12, 0, 0, 1), 0x06010002u);  // its mapping is fixed
  bus.sync_manager(kStation, 2, 0x1100, 4, 0x64);
  bus.sync_manager(kStation, 3, 0x1180, 8, 0x20);
  bus.fmmu(kStation, 0, 0, 4, 0x1100, 2);
  bus.fmmu(kStation, 1, 4, 8, 0x1180, 1);
  ASSERT_EQ(bus.request(kStation, 4), 4);
  EXPECT_TRUE(segment.set_object(StationId{0}, {0x6010, 1}, -1234));
  bus.request(kStation, 8);
  bus.logical(12, 0, bytes(0x80017FFE, 4) + Raw(8));
  bus.wait(milliseconds(2));
  const Answer a = bus.logical(12, 0, bytes(0x80017FFE, 4) + Raw(8));
  EXPECT_EQ(a.wkc, 3);
  EXPECT_EQ(static_cast<std::int16_t>(value(a.data, 6, 2)), -1234);
  EXPECT_EQ(segment.station(0).objects().value({0x7010, 1}), 0x7FFE);
  EXPECT_EQ(segment.station(0).objects().value({0x7020, 1}), -32767);
  bus.wait(milliseconds(150));  // watchdog: outputs go to 0
  segment.advance();
  EXPECT_EQ(segment.station(0).objects().value({0x7010, 1}), 0);
}

TEST(LyingStations, answer_writes_and_keep_their_values) {
  config::Machine machine = one("drives/id286.yaml");
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  bus.address_all();
  bus.mailboxes(kStation);
  ASSERT_EQ(bus.request(kStation, 2), 2);
  segment.ignore_writes(StationId{0}, config::ObjectAddress{0x6098, 0});
  EXPECT_EQ(bus.sdo_write(kStation, 0x6098, 0, 19, 1), 0u);
  EXPECT_NE(bus.sdo_read(kStation, 0x6098, 0), 19u);
  EXPECT_EQ(bus.sdo_write(kStation, 0x607A, 0, 5, 4), 0u);
  EXPECT_EQ(bus.sdo_read(kStation, 0x607A, 0), 5u);
  segment.ignore_writes(StationId{0}, std::nullopt);
  EXPECT_EQ(bus.sdo_write(kStation, 0x6098, 0, 19, 1), 0u);
  EXPECT_EQ(bus.sdo_read(kStation, 0x6098, 0), 19u);
  // A statusword that is stuck does not show the fault.
  bus.wait(milliseconds(2));
  const auto before = bus.sdo_read(kStation, 0x6041, 0);
  segment.stick_statusword(AxisId{0}, 0, true);
  segment.drive_fault(AxisId{0}, 0, 0x000A);
  bus.wait(milliseconds(2));
  bus.fetch(kStation);  // the emergency
  EXPECT_EQ(bus.sdo_read(kStation, 0x6041, 0), before);
  segment.stick_statusword(AxisId{0}, 0, false);
  bus.wait(milliseconds(2));
  bus.fetch(kStation);
  EXPECT_NE(bus.sdo_read(kStation, 0x6041, 0), before);
  segment.count_errors(StationId{0}, 1, 3);
  EXPECT_EQ(value(bus.read(kStation, 0x0302, 1).data), 3u);
}

TEST(Stations, may_be_sixty_four) {
  config::Machine machine;
  for (int i = 0; i < 64; ++i) add_station(machine, i % 2 == 0 ? "devices/aio4.yaml" : "devices/dio16.yaml");
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  EXPECT_EQ(bus.address_all(), 64);
  bus.wait(milliseconds(1));
  EXPECT_EQ(bus.send(8, 0, 0x0120, bytes(0x11, 2)).wkc, 64);
}

}  // namespace
}  // namespace gantry::sim::test
