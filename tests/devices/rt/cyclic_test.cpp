#include "devices/rt/cyclic.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <random>
#include <thread>

#include "tests/devices/rt/fake_port.hpp"

namespace gantry::devices {
namespace {

struct Bench {
  std::vector<std::byte> outputs = std::vector<std::byte>(4, std::byte{0x11});
  std::vector<std::byte> inputs = std::vector<std::byte>(3, std::byte{0});
  FakePort port;
  AcyclicSlot acyclic;
  /// Two stations with outputs and inputs each, side by side in the map: 2 + 1 and 2 + 2 bytes.
  std::vector<CyclicStation> stations{
      {.address = 0x1001, .logical = 0x10000, .region_bytes = 3, .input_at = 2, .output_bytes = 2, .input_bytes = 1},
      {.address = 0x1002,
       .logical = 0x10003,
       .region_bytes = 4,
       .input_at = 2,
       .output_bytes = 2,
       .input_bytes = 2,
       .output_offset = 2,
       .input_offset = 1}};
  Cyclic cyclic{{.stations = stations, .reference_address = 0x1001, .stations_on_bus = 2}, outputs, inputs};
  Bench() {
    port.stations = stations;
    port.inputs = {std::byte{1}, std::byte{2}, std::byte{3}};
    port.dc_time = 123'456'789'000;
  }
  Exchange run() { return cyclic.run(port, acyclic, Time{}); }
};

TEST(Cyclic, exchanges_outputs_and_inputs_in_one_frame) {
  Bench b;
  const Exchange e = b.run();
  EXPECT_EQ(e.fault, Fault::None);
  EXPECT_TRUE(e.inputs_fresh);
  EXPECT_EQ(e.ethercat.working_counter, 6);
  EXPECT_EQ(e.reference_ns, 123'456'789'000u);
  EXPECT_EQ(e.ethercat.al_states, 8);
  EXPECT_EQ(b.inputs[2], std::byte{3});
  EXPECT_EQ(b.port.seen_outputs[3], std::byte{0x11});
  EXPECT_EQ(b.port.sent, 1);
}

// What is put aside for somebody else to send never stands for an exchange, whenever it comes back.
TEST(Cyclic, a_spare_frame_carries_outputs_of_its_own_and_its_answer_is_late) {
  for (const int cycles : {0, 1, 126, 127, 128, 129, 255, 256, 1000, 65'535}) {
    Bench b;
    for (int i = 0; i < cycles; ++i) b.run();
    const std::vector<std::byte> others(4, std::byte{0x7E});
    std::array<FrameBytes, 2> spare;
    ASSERT_EQ(b.cyclic.spare_frames(others, spare), 1u);
    for (int i = 0; i < 3; ++i) {
      const auto before = b.cyclic.counters();
      b.port.send(PortIndex::Primary, spare[0].all());
      EXPECT_EQ(b.port.seen_outputs[3], std::byte{0x7E});
      EXPECT_EQ(b.run().fault, Fault::None);
      EXPECT_EQ(b.port.seen_outputs[3], std::byte{0x11});
      EXPECT_EQ(b.cyclic.counters().late, before.late + 1) << cycles << " + " << i;
      EXPECT_EQ(b.cyclic.counters().malformed, before.malformed);
    }
  }
}

TEST(Cyclic, spare_frames_reach_every_station_of_a_map_of_several_frames) {
  std::mt19937 random(7);
  for (int n = 0; n < 200; ++n) {
    Bench b;
    b.stations.clear();
    std::uint32_t logical = 0x10000, output_offset = 0;
    const int count = std::uniform_int_distribution(1, 60)(random);
    for (int i = 0; i < count; ++i) {
      const auto out = static_cast<std::uint16_t>(std::uniform_int_distribution(0, 120)(random));
      const auto in = static_cast<std::uint16_t>(std::uniform_int_distribution(0, 40)(random));
      b.stations.push_back({.address = static_cast<std::uint16_t>(0x1001 + i),
                            .logical = logical,
                            .region_bytes = static_cast<std::uint16_t>(out + in),
                            .input_at = out,
                            .output_bytes = out,
                            .input_bytes = in,
                            .output_offset = output_offset,
                            .lrw = random() % 4 != 0});
      logical += out + in, output_offset += out;
    }
    b.port.stations = b.stations;
    b.port.inputs.assign(60 * 40, std::byte{0});
    b.port.seen_outputs.assign(output_offset, std::byte{0});
    std::vector<std::byte> outputs(output_offset), inputs(60 * 40), now(output_offset);
    for (auto& byte : outputs) byte = static_cast<std::byte>(random());
    Cyclic cyclic{{.stations = b.stations, .reference_address = 0x1001, .stations_on_bus = 2}, now, inputs};
    std::array<FrameBytes, kMaxCyclicFrames> spare;
    const std::size_t frames = cyclic.spare_frames(outputs, spare);
    EXPECT_GE(frames * kMaxFrameBytes, outputs.size());
    for (std::size_t i = 0; i < frames; ++i) b.port.send(PortIndex::Primary, spare[i].all());
    EXPECT_EQ(b.port.seen_outputs, outputs) << "seed 7, case " << n << ", " << frames << " frames";
  }
}

TEST(Cyclic, a_wrong_working_counter_leaves_the_inputs_alone) {
  Bench b;
  b.run();
  b.port.inputs = {std::byte{9}, std::byte{9}, std::byte{9}};
  b.port.counter_error = -1;
  EXPECT_EQ(b.run().fault, Fault::TooFewTookPart);
  EXPECT_EQ(b.inputs[0], std::byte{1});
  b.port.counter_error = 1;
  const Exchange high = b.run();
  EXPECT_EQ(high.fault, Fault::TooManyTookPart);
  EXPECT_FALSE(high.inputs_fresh);
  EXPECT_EQ(b.inputs[0], std::byte{1});
}

TEST(Cyclic, a_station_more_or_less_in_the_broadcast_is_noticed) {
  Bench b;
  b.port.brd_counter = 1;
  EXPECT_EQ(b.run().fault, Fault::TooFewTookPart);
  b.port.brd_counter = 3;
  EXPECT_EQ(b.run().fault, Fault::TooManyTookPart);
}

TEST(Cyclic, a_lost_frame_is_told_from_a_dead_link) {
  Bench b;
  b.port.lose = true;
  EXPECT_EQ(b.run().fault, Fault::FrameLost);
  b.port.up = false;
  EXPECT_EQ(b.run().fault, Fault::BusDown);
}

TEST(Cyclic, frames_of_an_earlier_cycle_are_dropped_and_counted) {
  Bench b;
  b.port.hold_back = true;
  EXPECT_EQ(b.run().fault, Fault::FrameLost);
  b.port.hold_back = false;
  b.port.release();
  b.port.inputs = {std::byte{7}, std::byte{7}, std::byte{7}};
  EXPECT_EQ(b.run().fault, Fault::None);
  EXPECT_EQ(b.inputs[0], std::byte{7});  // of this cycle, not of the late frame
  EXPECT_EQ(b.cyclic.counters().late, 1u);
  b.port.twice = true;
  b.run();
  b.port.twice = false;
  EXPECT_EQ(b.run().fault, Fault::None);
  EXPECT_EQ(b.cyclic.counters().late, 1u);
  EXPECT_EQ(b.cyclic.counters().duplicate, 1u);  // its original was taken
}

TEST(Cyclic, a_flood_of_foreign_frames_does_not_hold_the_loop) {
  Bench b;
  b.port.lose = true;
  for (int i = 0; i < 1000; ++i) b.port.waiting.push_back(std::vector<std::byte>(60, std::byte{0x42}));
  EXPECT_EQ(b.run().fault, Fault::FrameLost);
  EXPECT_EQ(b.cyclic.counters().foreign, 64u);
}

// ---- every cycle and every frame is counted as what it was, and as nothing else ----

/// What one run() has added to the counters.
CyclicCounts added(Bench& b, Fault expected) {
  const CyclicCounts before = b.cyclic.counters();
  EXPECT_EQ(b.run().fault, expected);
  const CyclicCounts now = b.cyclic.counters();
  return {.sent = now.sent - before.sent,
          .not_sent = now.not_sent - before.not_sent,
          .lost = now.lost - before.lost,
          .late = now.late - before.late,
          .duplicate = now.duplicate - before.duplicate,
          .foreign = now.foreign - before.foreign,
          .malformed = now.malformed - before.malformed,
          .untouched = now.untouched - before.untouched,
          .wkc_zero = now.wkc_zero - before.wkc_zero,
          .wkc_low = now.wkc_low - before.wkc_low,
          .wkc_high = now.wkc_high - before.wkc_high};
}

TEST(CyclicCounts, a_cycle_that_went_well_is_a_frame_that_was_sent) {
  Bench b;
  EXPECT_EQ(added(b, Fault::None), (CyclicCounts{.sent = 1}));
}

TEST(CyclicCounts, a_frame_that_does_not_come_back_is_lost) {
  Bench b;
  b.port.lose = true;
  EXPECT_EQ(added(b, Fault::FrameLost), (CyclicCounts{.sent = 1, .lost = 1}));
  b.port.up = false;
  EXPECT_EQ(added(b, Fault::BusDown), (CyclicCounts{.not_sent = 1, .lost = 1}));
}

TEST(CyclicCounts, a_frame_that_comes_back_and_that_nobody_has_served_is_not_lost) {
  Bench b;
  b.port.alive = {false, false};  // it has passed stations, which are not in SAFE_OP
  EXPECT_EQ(added(b, Fault::TooFewTookPart), (CyclicCounts{.sent = 1, .wkc_zero = 1}));
  b.port.alive = {};
  b.port.loop_back = true;  // a plug that returns everything, in place of the first station
  EXPECT_EQ(added(b, Fault::TooFewTookPart), (CyclicCounts{.sent = 1, .untouched = 1, .wkc_zero = 1}));
  EXPECT_FALSE(b.cyclic.fresh(0));
  EXPECT_FALSE(b.cyclic.fresh(1));
  StationHealth health;
  const bool looked = b.cyclic.health(0, health);
  EXPECT_TRUE(!looked || health.looks <= 2);
}

TEST(CyclicCounts, a_low_and_a_high_working_counter_are_told_apart) {
  Bench b;
  b.port.counter_error = -1;
  EXPECT_EQ(added(b, Fault::TooFewTookPart), (CyclicCounts{.sent = 1, .wkc_low = 1}));
  b.port.counter_error = 1;
  EXPECT_EQ(added(b, Fault::TooManyTookPart), (CyclicCounts{.sent = 1, .wkc_high = 1}));
  b.port.counter_error = 0;
  b.port.brd_counter = 1;  // one that has no process data is missing
  EXPECT_EQ(added(b, Fault::TooFewTookPart), (CyclicCounts{.sent = 1, .wkc_low = 1}));
}

// R15.
TEST(CyclicCounts, an_echo_before_the_answer_harms_nothing_and_is_counted) {
  Bench b;
  b.port.echo = true;
  EXPECT_EQ(added(b, Fault::None), (CyclicCounts{.sent = 1, .untouched = 1}));
  EXPECT_TRUE(b.cyclic.fresh(0));
}

// R13.
TEST(CyclicCounts, late_and_duplicate_frames_are_told_apart_for_256_frames) {
  for (const int age : {1, 2, 100, 254, 255}) {
    SCOPED_TRACE(age);
    Bench b;
    for (int i = 0; i < 300; ++i) b.run();
    b.port.twice = true;
    b.run();
    b.port.twice = false;
    auto copy = b.port.waiting.front();
    b.port.waiting.clear();
    b.port.hold_back = true;
    b.run();
    b.port.hold_back = false;
    for (int i = 2; i < age; ++i) b.run();
    b.port.waiting.push_back(copy);
    EXPECT_EQ(added(b, Fault::None), (CyclicCounts{.sent = 1, .duplicate = 1}));
    b.port.release();
    EXPECT_EQ(added(b, Fault::None), (CyclicCounts{.sent = 1, .late = 1}));
  }
}

TEST(CyclicCounts, foreign_and_spoilt_frames_have_their_numbers) {
  Bench b;
  b.run();
  b.port.waiting.push_back(std::vector<std::byte>(60, std::byte{0x42}));  // not EtherCAT
  b.port.twice = true;
  b.run();
  EXPECT_FALSE(b.cyclic.other_master());
  auto another = b.port.waiting.front();  // as another master's would be
  b.port.waiting.clear();
  b.port.twice = false;
  another[7] ^= std::byte{0x01};
  b.port.waiting.push_back(another);
  b.port.waiting.push_back(std::vector<std::byte>(10, std::byte{0}));
  EXPECT_EQ(added(b, Fault::None), (CyclicCounts{.sent = 1, .foreign = 1, .malformed = 1}));
  EXPECT_EQ(b.cyclic.counters().foreign, 2u);
  EXPECT_FALSE(b.cyclic.other_master());  // one may be a late answer that was changed on the way
  b.port.waiting.push_back(another);
  EXPECT_EQ(added(b, Fault::None), (CyclicCounts{.sent = 1, .foreign = 1}));
  EXPECT_FALSE(b.cyclic.other_master());
  b.port.waiting.push_back(another);
  EXPECT_EQ(added(b, Fault::None), (CyclicCounts{.sent = 1, .foreign = 1}));
  OtherMaster other{.frames = 3};
  std::copy_n(another.begin() + 6, other.address.size(), other.address.begin());
  EXPECT_EQ(b.cyclic.other_master(), other);
}

/// Each bit of an answer's header once: of its addresses, its type, its length and its first datagram. 264 frames.
TEST(CyclicCounts, an_answer_with_a_changed_header_is_of_no_other_master) {
  Bench b;
  b.run();
  constexpr std::size_t kSource = 6, kType = 12;
  for (std::size_t at = 0; at < kFrameHeader + kDatagramHeader + 7; ++at)
    for (int bit = 0; bit < 8; ++bit) {
      SCOPED_TRACE(testing::Message() << "byte " << at << ", bit " << bit);
      const CyclicCounts before = b.cyclic.counters();
      b.port.changed = [&](auto& answer) { answer[at] ^= static_cast<std::byte>(1 << bit); };
      b.run();
      b.port.changed = {};
      b.run();
      const CyclicCounts came = b.cyclic.counters() - before;
      EXPECT_EQ(came.foreign, 0u);
      EXPECT_EQ(came.late + came.malformed + came.duplicate, came.lost);
      const bool by_stations = at == kSource && bit == 1;  // they set it; no working counter shows it here
      if (at >= kSource && at < kType + 2 && !by_stations) {
        EXPECT_EQ(came.malformed, 1u);
      }
    }
  EXPECT_FALSE(b.cyclic.other_master());
}

/// The same when they come a cycle late: then nothing tells whose they were.
TEST(CyclicCounts, late_answers_with_changed_sources_are_of_no_other_master) {
  Bench b;
  b.run();
  for (std::size_t at = 6; at < 12; ++at)
    for (int bit = 0; bit < 8; ++bit) {
      b.port.hold_back = true;
      b.run();
      b.port.hold_back = false;
      b.port.held.front()[at] ^= static_cast<std::byte>(1 << bit);
      b.port.release();
      b.run();
    }
  EXPECT_EQ(b.cyclic.counters().foreign, 47u);  // and one whose bit stations set anyway
  EXPECT_FALSE(b.cyclic.other_master());
}

TEST(CyclicCounts, can_be_read_in_another_thread_and_never_run_backward) {
  Bench b;
  std::atomic<bool> stop{false};
  std::thread reader([&] {
    for (CyclicCounts last; !stop.load();) {
      const CyclicCounts now = b.cyclic.counters();
      ASSERT_GE(now.sent, last.sent);
      ASSERT_GE(now.lost, last.lost);
      last = now;
    }
  });
  for (int i = 0; i < 20'000; ++i) {
    b.port.lose = i % 3 == 0;
    b.run();
  }
  stop = true;
  reader.join();
  EXPECT_EQ(b.cyclic.counters().sent, 20'000u);
  EXPECT_EQ(b.cyclic.counters().lost, 6667u);
}

TEST(Cyclic, a_datagram_of_the_run_thread_rides_along_and_is_answered) {
  Bench b;
  std::array<std::byte, 2> answer{}, other{};
  std::array both{Datagram{wire::Command::Fprd, wire::physical_address(0x1002, 0x0130), answer},
                  Datagram{wire::Command::Fprd, wire::physical_address(0x1001, 0x0130), other}};
  ASSERT_TRUE(b.acyclic.post(both));
  EXPECT_FALSE(b.acyclic.post(both));  // one asker at a time
  EXPECT_EQ(b.acyclic.take({}), AcyclicSlot::Taken::Pending);
  b.run();
  EXPECT_EQ(b.port.sent, 1);
  ASSERT_EQ(b.acyclic.take(both), AcyclicSlot::Taken::Answered);
  EXPECT_EQ(answer[1], std::byte{0x77});
  EXPECT_EQ(other[0], std::byte{0x77});
  EXPECT_EQ(both[1].working_counter, 1);

  ASSERT_TRUE(b.acyclic.post(both));
  b.port.lose = true;
  b.run();
  EXPECT_EQ(b.acyclic.take(both), AcyclicSlot::Taken::Lost);
}

// Every frame carries its number as input; whatever is lost, doubled or delayed, a fresh input is always of its own
// cycle.
TEST(Cyclic, loss_delay_and_duplication_never_give_an_input_of_another_cycle) {
  const unsigned seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  Bench b;
  std::uint64_t lost = 0;
  for (unsigned cycle = 1; cycle <= 200'000; ++cycle) {
    const unsigned dice = static_cast<unsigned>(random()) % 100;
    b.port.lose = dice == 0;
    b.port.hold_back = dice == 1 || dice == 2;
    b.port.twice = dice == 3;
    if (dice == 4) b.port.release();
    for (std::size_t i = 0; i < 3; ++i) b.port.inputs[i] = static_cast<std::byte>(cycle >> (8 * i));
    const Exchange e = b.run();
    if (!e.inputs_fresh) {
      ++lost;
      continue;
    }
    unsigned got = 0;
    for (std::size_t i = 0; i < 3; ++i) got |= std::to_integer<unsigned>(b.inputs[i]) << (8 * i);
    ASSERT_EQ(got, cycle);
  }
  EXPECT_EQ(b.cyclic.counters().lost, lost);
  EXPECT_GT(lost, 1000u);
}

}  // namespace
}  // namespace gantry::devices
