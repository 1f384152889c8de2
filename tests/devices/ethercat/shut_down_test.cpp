// The end of cyclic operation against the virtual segment: where every station is left, what it has shown on its way
// there, how long it took, and whether the next start finds them in order. The stations' own registers are the judge.
#include <algorithm>
#include <random>
#include <set>

#include "devices/ethercat/leave.hpp"
#include "devices/passing_port.hpp"
#include "sim/esc/timing.hpp"
#include "sim/station/station.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {
namespace {

using wire::AlState;

/// Looks at every station after each frame: errors that it shows are kept.
class WatchingPort final : public PassingPort {
 public:
  WatchingPort(FramePort& port, sim::Segment& segment, const Clock& clock)
      : PassingPort(port), segment_(segment), clock_(clock) {}
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override {
    const bool sent = port_.send(port, frame);
    for (int p = 0; watching && p < segment_.station_count(); ++p) {
      std::array<std::byte, 6> raw{};
      read_al(p, raw);
      const auto status = wire::get_le<std::uint16_t>(raw, 0);
      if ((status & wire::kAlError) != 0) codes.insert(wire::get_le<std::uint16_t>(raw, 4));
    }
    return sent;
  }
  void read_al(int position, std::span<std::byte> raw) {
    segment_.station(position).esc().read(wire::reg::kAlStatus, raw, clock_.now());
  }
  bool watching = false;
  std::set<std::uint16_t> codes;

 private:
  sim::Segment& segment_;
  const Clock& clock_;
};

struct ShutDownBench : BusBench {
  WatchingPort watch{port, segment, clock};
  ShutDownBench() {
    port_used = &watch;
    operate();
  }
  Time shut_down() {
    watch.watching = true;
    const Time begin = clock.now();
    master->shut_down();
    watch.watching = false;
    return clock.now() - begin;
  }
  [[nodiscard]] std::uint16_t al(int position, std::size_t at) {
    std::array<std::byte, 6> raw{};
    watch.read_al(position, raw);
    return wire::get_le<std::uint16_t>(raw, at);
  }
  void expect_in_init(int position) {
    EXPECT_EQ(segment.station(position).state(), AlState::Init) << position;
    EXPECT_EQ(al(position, 0), 1) << position;  // INIT and no error bit
    EXPECT_EQ(al(position, 4), 0) << position;  // AL status code
    EXPECT_FALSE(segment.station(position).esc().dc().sync0_active()) << position;
  }
  void expect_all_in_init() {
    for (int p = 0; p < segment.station_count(); ++p) expect_in_init(p);
  }
  void expect_works_again() {
    segment.faults().set_noise({});
    operate();
    cycles(50);
    EXPECT_EQ(last.fault, Fault::None);
    EXPECT_TRUE(last.inputs_fresh);
  }
};

TEST(ShutDown, leaves_every_station_in_init_and_none_shows_an_error_on_its_way) {
  ShutDownBench b;
  b.enable();
  EXPECT_LT(b.shut_down(), milliseconds(50));
  b.expect_all_in_init();
  EXPECT_TRUE(b.watch.codes.empty()) << std::hex << *b.watch.codes.begin();
  EXPECT_TRUE(b.master->notes().empty()) << b.master->notes().front();
  b.expect_works_again();
}

TEST(ShutDown, waits_for_stations_that_are_slow_and_their_watchdogs_do_not_expire_meanwhile) {
  for (const Time slow : std::initializer_list<Time>{Time{0}, microseconds(900), milliseconds(20), milliseconds(150),
                                                     milliseconds(190)}) {
    SCOPED_TRACE(slow.count());
    ShutDownBench b;
    b.segment.set_timing({.al_down = slow});
    EXPECT_LT(b.shut_down(), 3 * slow + milliseconds(100));
    b.expect_all_in_init();
    EXPECT_TRUE(b.watch.codes.empty()) << std::hex << *b.watch.codes.begin();
    EXPECT_TRUE(b.master->notes().empty());
    b.segment.set_timing({});
    b.expect_works_again();
  }
}

TEST(ShutDown, brings_stations_down_that_are_slower_than_a_state_may_take) {
  for (const Time slow : {milliseconds(300), milliseconds(700)}) {
    SCOPED_TRACE(slow.count());
    ShutDownBench b;
    b.segment.set_timing({.al_down = slow});
    EXPECT_LE(b.shut_down(), kLeaveAtMost + milliseconds(200));
    b.expect_all_in_init();
  }
}

TEST(ShutDown, ends_in_bounded_time_with_stations_that_never_get_there_and_names_them) {
  ShutDownBench b;
  b.segment.set_timing({.al_down = milliseconds(60'000)});
  EXPECT_LE(b.shut_down(), kLeaveAtMost + milliseconds(200));
  ASSERT_EQ(b.master->notes().size(), 6u);
  EXPECT_NE(b.master->notes().front().find("stays in OP"), std::string::npos) << b.master->notes().front();
}

TEST(ShutDown, acknowledges_the_errors_that_stations_already_show) {
  ShutDownBench b;
  b.clock.sleep_until(b.due + milliseconds(500));  // all of them fall back by their watchdogs
  b.segment.advance();
  for (int p = 0; p < b.segment.station_count(); ++p) ASSERT_EQ(b.al(p, 0), 0x14);
  EXPECT_LT(b.shut_down(), milliseconds(200));
  b.expect_all_in_init();
  b.expect_works_again();
}

TEST(ShutDown, goes_on_without_stations_that_are_dead) {
  const int stations = 6;
  for (int dead = 0; dead < stations; ++dead) {
    SCOPED_TRACE(dead);
    ShutDownBench b;
    const auto id = b.master->stations()[static_cast<std::size_t>(dead)].id;
    b.segment.power_off(id);  // with it, the line behind it is out of reach
    EXPECT_LT(b.shut_down(), milliseconds(500));
    for (int p = 0; p < dead; ++p) b.expect_in_init(p);
    EXPECT_EQ(b.master->notes().size(), static_cast<std::size_t>(stations - dead));
    b.clock.sleep_until(b.clock.now() + milliseconds(300));
    b.segment.power_on(id);
    b.expect_works_again();
  }
}

TEST(ShutDown, of_a_bus_that_is_silent_ends_at_once) {
  ShutDownBench b;
  b.segment.cut_link(0);
  EXPECT_LT(b.shut_down(), milliseconds(500));
  EXPECT_EQ(b.master->notes().size(), 6u);
}

TEST(ShutDown, gets_there_over_a_cable_that_loses_every_fifth_frame) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    SCOPED_TRACE(seed);
    ShutDownBench b;
    b.segment.faults().set_noise({.loss = 0.2, .seed = seed});
    EXPECT_LE(b.shut_down(), milliseconds(2000));
    b.expect_all_in_init();
    EXPECT_TRUE(b.watch.codes.empty()) << std::hex << *b.watch.codes.begin();
    b.expect_works_again();
  }
}

TEST(ShutDown, before_op_was_ever_asked_for_and_twice_in_a_row) {
  BusBench b;
  ASSERT_TRUE(b.bring_up());
  b.cycles(5);
  b.master->shut_down();
  for (int p = 0; p < b.segment.station_count(); ++p) EXPECT_EQ(b.segment.station(p).state(), AlState::Init);
  const Time begin = b.clock.now();
  b.master->shut_down();
  EXPECT_EQ(b.clock.now(), begin);
}

}  // namespace
}  // namespace gantry::devices
