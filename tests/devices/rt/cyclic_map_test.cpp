// The cyclic exchange over maps of several stations and several frames, and against a bad cable.
#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <random>

#include "devices/passing_port.hpp"
#include "devices/rt/cyclic.hpp"
#include "tests/devices/rt/fake_port.hpp"

namespace gantry::devices {
namespace {

struct MapBench {
  std::vector<CyclicStation> stations;
  std::vector<std::byte> outputs, inputs;
  FakePort port;
  AcyclicSlot acyclic;
  std::unique_ptr<Cyclic> cyclic;

  MapBench(std::size_t count, std::uint16_t out, std::uint16_t in, bool overlapped = false, bool roll = true) {
    std::uint32_t logical = 0x10000;
    for (std::size_t i = 0; i < count; ++i) {
      CyclicStation s{.address = static_cast<std::uint16_t>(0x1001 + i),
                      .logical = logical,
                      .region_bytes = overlapped ? std::max(out, in) : static_cast<std::uint16_t>(out + in),
                      .input_at = overlapped ? std::uint16_t{0} : out,
                      .output_bytes = out,
                      .input_bytes = in,
                      .output_offset = static_cast<std::uint32_t>(i * out),
                      .input_offset = static_cast<std::uint32_t>(i * in)};
      logical += s.region_bytes;
      stations.push_back(s);
    }
    outputs.resize(count * out);
    inputs.resize(count * in);
    port.stations = stations;
    port.inputs.resize(inputs.size());
    port.alive.assign(count, true);
    port.brd_counter = static_cast<std::uint16_t>(count);
    rebuild(roll);
  }
  void rebuild(bool roll = true) {
    port.stations = stations;
    cyclic = std::make_unique<Cyclic>(CyclicLayout{.stations = stations,
                                                   .reference_address = 0x1001,
                                                   .stations_on_bus = static_cast<std::uint16_t>(stations.size()),
                                                   .roll = roll},
                                      outputs, inputs);
  }
  Exchange run() { return cyclic->run(port, acyclic, Time{}); }
  void fill(unsigned seed) {
    std::mt19937 random(seed);
    for (auto& b : outputs) b = static_cast<std::byte>(random());
    for (auto& b : port.inputs) b = static_cast<std::byte>(random());
  }
  void expect_exchanged() {
    EXPECT_TRUE(std::equal(outputs.begin(), outputs.end(), port.seen_outputs.begin()));
    EXPECT_EQ(inputs, port.inputs);
  }
};

TEST(CyclicMap, sixty_four_stations_exchange_in_several_frames_of_one_cycle) {
  for (const bool overlapped : {false, true}) {
    MapBench b(64, 24, 32, overlapped);
    b.fill(3);
    const Exchange e = b.run();
    EXPECT_EQ(e.fault, Fault::None);
    EXPECT_TRUE(e.inputs_fresh);
    EXPECT_EQ(e.ethercat.expected, 64 * 3);
    EXPECT_EQ(e.ethercat.working_counter, e.ethercat.expected);
    b.expect_exchanged();
    EXPECT_EQ(b.port.sent, overlapped ? 2 : 3);
    EXPECT_EQ(b.cyclic->counters().sent, static_cast<std::uint64_t>(b.port.sent));
  }
}

TEST(CyclicMap, stations_that_cannot_lrw_are_reached_by_lwr_and_lrd) {
  MapBench b(7, 5, 9);
  for (const std::size_t i : {2u, 3u, 6u}) b.stations[i].lrw = false;
  b.stations[6].output_bytes = 0;
  b.stations[6].region_bytes = 9, b.stations[6].input_at = 0;
  b.rebuild();
  b.fill(4);
  const Exchange e = b.run();
  EXPECT_EQ(e.fault, Fault::None);
  EXPECT_EQ(e.ethercat.expected, 4 * 3 + 2 * 2 + 1);
  EXPECT_EQ(e.ethercat.working_counter, e.ethercat.expected);
  EXPECT_EQ(b.inputs, b.port.inputs);
  EXPECT_TRUE(std::equal(b.outputs.begin(), b.outputs.begin() + 30, b.port.seen_outputs.begin()));
}

TEST(CyclicMap, a_station_that_does_not_take_part_is_found_and_the_others_go_on) {
  MapBench b(20, 9, 19);
  b.fill(1);
  b.run();
  b.port.alive[7] = false;
  b.port.brd_counter = 19;
  const auto old = b.inputs;
  b.fill(2);
  const Exchange first = b.run();  // the sum is wrong: nobody's inputs are believed
  EXPECT_EQ(first.fault, Fault::TooFewTookPart);
  EXPECT_FALSE(first.inputs_fresh);
  EXPECT_EQ(b.inputs, old);
  for (int i = 0; i < 50; ++i) {
    b.fill(static_cast<unsigned>(10 + i));
    const Exchange e = b.run();
    EXPECT_EQ(e.fault, Fault::TooFewTookPart);
    for (std::size_t s = 0; s < 20; ++s) {
      EXPECT_EQ(b.cyclic->fresh(s), s != 7) << s;
      EXPECT_EQ(b.cyclic->was_fresh(s), s != 7) << s;
      const auto at = static_cast<std::ptrdiff_t>(19 * s);
      const auto& now = s == 7 ? old : b.port.inputs;
      EXPECT_TRUE(std::equal(b.inputs.begin() + at, b.inputs.begin() + at + 19, now.begin() + at)) << s;
    }
  }
  b.port.alive[7] = true;
  b.port.brd_counter = 20;
  const Exchange back = b.run();
  EXPECT_EQ(back.fault, Fault::None);
  EXPECT_TRUE(back.inputs_fresh);
  for (int i = 0; i < 200; ++i) b.run();
  StationHealth h;
  ASSERT_TRUE(b.cyclic->health(7, h));
  EXPECT_EQ(h.stale_cycles, 50u);
  ASSERT_TRUE(b.cyclic->health(6, h));
  EXPECT_EQ(h.stale_cycles, 0u);
  b.port.sent = 0;
  b.run();
  EXPECT_EQ(b.port.sent, 1);  // and all in one datagram again
}

TEST(CyclicMap, every_station_is_looked_at_in_turn) {
  MapBench b(5, 2, 2);
  for (int i = 0; i < 25; ++i) b.run();
  for (std::size_t s = 0; s < 5; ++s) {
    StationHealth h;
    ASSERT_TRUE(b.cyclic->health(s, h));
    EXPECT_EQ(h.looks, 5u);
    EXPECT_EQ(h.errors[3], std::byte{0x77});
  }
}

TEST(CyclicMap, a_reference_clock_of_32_bits_goes_on_over_its_wrap) {
  MapBench b(2, 2, 2);
  const std::uint64_t begin = 0x1'FFFF'0000;  // 65 us before the wrap
  b.cyclic = std::make_unique<Cyclic>(CyclicLayout{.stations = b.stations,
                                                   .reference_address = 0x1001,
                                                   .reference_wide = false,
                                                   .dc_time_ns = begin + 40'000,  // about
                                                   .stations_on_bus = 2},
                                      b.outputs, b.inputs);
  for (std::uint64_t cycle = 0; cycle < 20'000; ++cycle) {
    const std::uint64_t now = begin + cycle * 1'000'000;
    b.port.dc_time = now & 0xFFFF'FFFF;
    ASSERT_EQ(b.run().reference_ns, now);
  }
}

TEST(CyclicMap, a_rider_as_large_as_a_mailbox_can_be_takes_a_frame_of_its_own) {
  MapBench b(3, 4, 4);
  std::vector<std::byte> mailbox(1486);
  Datagram one{wire::Command::Fprd, wire::physical_address(0x1001, 0x1080), mailbox};
  ASSERT_TRUE(b.acyclic.post(std::span(&one, 1)));
  b.run();
  EXPECT_EQ(b.port.sent, 2);
  EXPECT_EQ(b.acyclic.take(std::span(&one, 1)), AcyclicSlot::Taken::Answered);
  EXPECT_EQ(mailbox[1485], std::byte{0x77});
  b.run();
  EXPECT_EQ(b.port.sent, 3);
}

/// A cable that loses, doubles, delays, reorders, and changes a bit of a header. Payload and working counters are under
/// the FCS: a hit there is a lost frame.
class BadCable final : public PassingPort {
 public:
  BadCable(FramePort& port, unsigned seed) : PassingPort(port), random_(seed) {}
  bool send(PortIndex p, std::span<const std::byte> frame) noexcept override {
    ++sent;
    std::vector<std::byte> copy(frame.begin(), frame.end());
    if (one_in(100)) return ++lost, true;
    if (one_in(50)) corrupt(copy);
    port_.send(p, copy);
    return true;
  }
  Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    for (;;) {
      const Received got = port_.receive(buffer, deadline);
      if (got.size == 0) break;
      std::vector<std::byte> frame(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(got.size));
      if (one_in(100)) continue;
      if (one_in(50)) corrupt(frame);
      if (one_in(50)) arriving_.push_back({frame, cycle + random_() % 4});
      arriving_.push_back({std::move(frame), cycle + (one_in(20) ? 1 + random_() % 300 : 0)});
      if (arriving_.size() > 1 && one_in(10)) std::swap(arriving_.back(), arriving_[random_() % arriving_.size()]);
    }
    for (auto it = arriving_.begin(); it != arriving_.end(); ++it) {
      if (it->due > cycle) continue;
      std::copy(it->bytes.begin(), it->bytes.end(), buffer.begin());
      const Received r{it->bytes.size(), PortIndex::Primary, Time{}};
      ++delivered;
      arriving_.erase(it);
      return r;
    }
    return {};
  }
  [[nodiscard]] bool link_up(PortIndex) const noexcept override { return true; }
  std::uint64_t cycle = 0, sent = 0, lost = 0, delivered = 0;

 private:
  struct Arriving {
    std::vector<std::byte> bytes;
    std::uint64_t due;
  };
  bool one_in(unsigned n) { return random_() % n == 0; }
  void corrupt(std::vector<std::byte>& frame) {
    using namespace wire;
    std::vector<std::size_t> headers;
    for (std::size_t i = 0; i < kFrameHeader; ++i) headers.push_back(i);
    for (std::size_t at = kFrameHeader; at + kDatagramHeader <= frame.size();) {
      for (std::size_t i = 0; i < kDatagramHeader; ++i) headers.push_back(at + i);
      const auto h = get_datagram_header(std::span<const std::byte>(frame).subspan(at));
      if (!h.more) break;
      at += kDatagramHeader + h.length + kWorkingCounter;
    }
    frame[headers[random_() % headers.size()]] ^= static_cast<std::byte>(1u << random_() % 8);
  }

  std::mt19937 random_;
  std::vector<Arriving> arriving_;
};

// Every input carries the number of its cycle. GANTRY_CAMPAIGN_CYCLES makes it the long campaign.
TEST(CyclicMap, whatever_a_cable_does_no_input_is_of_another_cycle) {
  const char* text = std::getenv("GANTRY_CAMPAIGN_CYCLES");
  const std::uint64_t cycles = text != nullptr ? std::strtoull(text, nullptr, 10) : 30'000;
  const unsigned seed = 20261121;
  SCOPED_TRACE(seed);
  MapBench b(40, 16, 24);  // two frames
  BadCable cable(b.port, seed);
  std::mt19937 random(seed);
  std::uint64_t fresh = 0, whole = 0;
  for (std::uint64_t cycle = 1; cycle <= cycles; ++cycle) {
    cable.cycle = cycle;
    for (std::size_t s = 0; s < 40; ++s)
      for (std::size_t i = 0; i < 24; ++i) b.port.inputs[24 * s + i] = static_cast<std::byte>(cycle >> (8 * (i % 8)));
    const auto before = b.inputs;
    const Exchange e = b.cyclic->run(cable, b.acyclic, Time{});
    whole += e.inputs_fresh;
    for (std::size_t s = 0; s < 40; ++s) {
      const auto at = static_cast<std::ptrdiff_t>(24 * s);
      const auto& want = b.cyclic->fresh(s) ? b.port.inputs : before;
      fresh += b.cyclic->fresh(s);
      ASSERT_TRUE(std::equal(b.inputs.begin() + at, b.inputs.begin() + at + 24, want.begin() + at))
          << "cycle " << cycle << " station " << s;
    }
    ASSERT_EQ(e.fault == Fault::None && !e.inputs_fresh, false);
  }
  const CyclicCounts& c = b.cyclic->counters();
  RecordProperty("fresh_percent", static_cast<int>(100 * fresh / (40 * cycles)));
  RecordProperty("lost", std::to_string(c.lost));
  RecordProperty("late", std::to_string(c.late));
  RecordProperty("malformed", std::to_string(c.malformed));
  RecordProperty("foreign", std::to_string(c.foreign));
  EXPECT_EQ(c.sent, cable.sent);  // every frame is either answered or counted as lost
  EXPECT_GE(c.lost, cable.lost);
  // And every frame that came in is counted once: an answer, or what it was instead.
  EXPECT_EQ(cable.delivered, c.sent - c.lost + c.late + c.duplicate + c.foreign + c.malformed + c.untouched);
  EXPECT_GT(c.duplicate, 0u);
  EXPECT_EQ(c.untouched, 0u);
  EXPECT_GT(whole, cycles / 2);
  EXPECT_GT(c.late, 0u);
  EXPECT_GT(c.malformed, 0u);
}

}  // namespace
}  // namespace gantry::devices
