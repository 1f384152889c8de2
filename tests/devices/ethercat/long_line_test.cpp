// As many stations as a segment may have: drives, analogue and digital terminals in one line.
#include <gtest/gtest.h>

#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {
namespace {

config::StationProfile profile(const std::string& name) {
  auto p = config::load_profile(std::string(GANTRY_SOURCE_DIR "/config/") + name + ".yaml");
  EXPECT_TRUE(p) << name;
  return p ? *p : config::StationProfile{};
}

/// `count` stations in turn of these profiles.
config::Machine line_of(int count) {
  const std::vector<config::StationProfile> kinds{profile("drives/amd530b"), profile("devices/aio4"),
                                                  profile("drives/std402ec"), profile("devices/dio16"),
                                                  profile("drives/id286")};
  config::Machine m;
  m.bus = reference_machine().bus;
  for (int i = 0; i < count; ++i) {
    config::Station s;
    s.id = StationId{static_cast<std::uint16_t>(i)};
    s.position = i;
    s.name = "s" + std::to_string(i);
    s.profile = kinds[static_cast<std::size_t>(i) % kinds.size()];
    m.stations.push_back(std::move(s));
  }
  return m;
}

// ETG.1000.4, 5.4: an LRW counts 2 for a station whose outputs it wrote and 1 for one whose inputs it read; LWR and LRD
// count 1 each. Every station here has both.
TEST(LongLine, sixty_four_stations_come_to_op_and_exchange_with_the_exact_working_counter) {
  constexpr int kStations = 64;
  const config::Machine machine = line_of(kStations);
  for (const MapKind map : {MapKind::Separate, MapKind::Overlapped}) {
    SCOPED_TRACE(static_cast<int>(map));
    VirtualClock clock;
    sim::Segment segment(machine, clock);
    sim::SegmentPort port(segment, clock);
    EthercatMaster master(machine, port, clock, {.map = map});
    const Time begin = clock.now();
    const auto up = master.bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
    ASSERT_EQ(master.stations().size(), 64u);
    Time due = master.first_cycle(clock.now());
    Exchange e;
    DcLock lock;
    const auto cycle = [&] {
      clock.sleep_until(due);
      e = master.exchange(due + microseconds(800));
      due += machine.bus.cycle + lock.step(e.reference_ns);
    };
    for (int i = 0; i < 20; ++i) cycle();
    master.step_by(cycle);  // what is asked from here on rides in the cycle's frames
    ASSERT_TRUE(master.request_operation());
    int needed = 0;
    for (; needed < 2000 && e.ethercat.al_states != 8; ++needed) cycle();
    ASSERT_EQ(e.ethercat.al_states, 8);
    const auto all = master.check_operation();
    ASSERT_TRUE(all) << to_text(all.error());
    RecordProperty(map == MapKind::Separate ? "until_op_ms" : "until_op_overlapped_ms",
                   static_cast<int>((clock.now() - begin) / milliseconds(1)));
    for (int i = 0; i < 1000; ++i) {
      cycle();
      ASSERT_EQ(e.fault, Fault::None) << "cycle " << i << ": " << code(e.fault).text;
      ASSERT_EQ(e.ethercat.expected, 3 * kStations);
      ASSERT_EQ(e.ethercat.working_counter, 3 * kStations);
      ASSERT_EQ(e.ethercat.al_states, 8);
    }
    // And each of them is one by itself: what is written to a station arrives there and nowhere else.
    for (const auto& s : machine.stations) {
      EXPECT_TRUE(master.fresh(s.id)) << s.name;
      if (s.profile.name != "dio16") continue;
      wire::put_le<std::uint16_t>(master.outputs(s.id), 0, static_cast<std::uint16_t>(0xA500 | s.position));
      segment.set_io_inputs(s.id, static_cast<std::uint16_t>(0x5A00 | s.position));
    }
    for (int i = 0; i < 5; ++i) cycle();
    for (const auto& s : machine.stations) {
      if (s.profile.name != "dio16") continue;
      EXPECT_EQ(segment.io_outputs(s.id), 0xA500 | s.position) << s.name;
      EXPECT_EQ(wire::get_le<std::uint16_t>(master.inputs(s.id), 0), 0x5A00 | s.position) << s.name;
    }
    // One that falls out is missed by exactly its share.
    segment.power_off(machine.stations.back().id);
    cycle();
    EXPECT_EQ(e.fault, Fault::TooFewTookPart);
    EXPECT_EQ(e.ethercat.working_counter, 3 * (kStations - 1));
    master.step_by({});
    master.shut_down();
  }
}

}  // namespace
}  // namespace gantry::devices
