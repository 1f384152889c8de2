// R62: what stands ready to be sent when the loop cannot speak, and what the loop does when somebody has spoken for it.
// Virtual time, the whole reference machine; the judge reads bytes (wire_judge.hpp), or is the virtual segment.
#include "app/cycle/stop_frame.hpp"

#include "app/job/limits.hpp"
#include "motion/path/bead.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry::test {
namespace {

using cycle::CommandKind;
using cycle::State;

constexpr std::uint16_t kEnableOperation = 0x000F, kQuickStop = 0x0002, kStand = 0x010F;  // CiA 402, command coding

/// Homed, and in the middle of a bead at 100 mm/s along X, with light and clamp on.
void dispense(LoopBench& b) {
  b.operate();
  b.enable();
  b.home();
  const std::uint32_t on = config::bit(config::Output::CameraLight) | config::bit(config::Output::Clamp);
  ASSERT_EQ(b.command({.kind = CommandKind::SetOutputs, .mask = on, .bits = on}), Fault::None);
  const motion::Limits limits = job::limits_of(b.machine);
  const AxisVec from{100, 100, -20, 0, 10};
  AxisVec to = from;
  to[0] = 300, to[1] = 150;
  const auto bead = motion::plan_bead(
      limits, {.points = {from, to}, .speed_mm_s = 100, .valve = config::bit(config::Output::Valve), .feature = 0});
  ASSERT_TRUE(bead) << to_text(bead.error());
  std::vector<motion::Segment> all = motion::line_move(limits, b.now.target, bead->start);
  all.insert(all.end(), bead->segments.begin(), bead->segments.end());
  b.play(all);
  ASSERT_TRUE(b.until([&] { return b.tap.last_image().valve(); }, 20'000));
  b.ticks(300);
  ASSERT_TRUE(b.tap.last_image().valve());
  ASSERT_EQ(b.now.state, State::Running);
  ASSERT_GT(b.now.path_speed, 99);
}

WireImage taken_over(LoopBench& b) {
  EXPECT_TRUE(cycle::send(b.stop));
  const auto frame = b.wire.read(1000);
  const auto image = decode_cyclic(frame);
  EXPECT_TRUE(image) << frame.size() << " bytes";
  EXPECT_TRUE(b.wire.read(0).empty()) << "one frame, once";
  return image.value_or(WireImage{});
}

TEST(StopFrame, before_the_first_cycle_there_is_nothing_to_send) {
  LoopBench b;
  EXPECT_FALSE(cycle::send(b.stop));
  EXPECT_TRUE(b.wire.read(0).empty());
}

TEST(StopFrame, stops_every_axis_puts_every_output_off_but_the_clamp_and_leaves_the_rest_as_last_commanded) {
  LoopBench b;
  dispense(b);
  const auto sent = b.tap.last();
  const WireImage last = b.tap.last_image();
  ASSERT_TRUE(last.all(kEnableOperation)) << last.text();
  ASSERT_EQ(last.outputs & 0x47, 0x43) << "valve, light and clamp: " << last.text();

  ASSERT_TRUE(cycle::send(b.stop));
  const auto frame = b.wire.read(1000);
  const auto stop = decode_cyclic(frame);
  ASSERT_TRUE(stop);
  EXPECT_TRUE(stop->is_stop()) << stop->text();
  EXPECT_EQ(stop->outputs, 0x40) << "the clamp alone: " << stop->text();
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(stop->axes[i].mode, 8) << "axis " << i << ": cyclic synchronous position";
    EXPECT_EQ(stop->axes[i].target, last.axes[i].target) << "axis " << i;
    EXPECT_EQ(stop->axes[i].probe, last.axes[i].probe) << "axis " << i;
  }
  // All other process data are those of the cycle's frame, and nothing but process data is in it.
  const std::size_t at = find_lrw(frame), sent_at = find_lrw(sent);
  std::size_t others = 0;
  for (std::size_t i = 0; i < kImageBytes; ++i) others += frame[at + i] != sent[sent_at + i] ? 1u : 0u;
  EXPECT_EQ(others, 6u + 1u) << "a byte of six controlwords (000Fh, 0002h or 010Fh), and one byte of outputs";
  EXPECT_EQ(frame.size(), at + kImageBytes + 2) << "LRW is the last";
  EXPECT_EQ(at, 16u + (10 + 4 + 2) + 10) << "before it an idle datagram with the frame's number";
  EXPECT_EQ(frame[16], std::byte{0}) << "NOP";
}

TEST(StopFrame, an_inverted_output_is_off_when_its_bit_is_set) {
  config::Machine machine = reference_machine();
  for (const auto output : {config::Output::Valve, config::Output::Healthy})
    machine.outputs[static_cast<std::size_t>(output)]->invert = true;
  LoopBench b(machine);
  b.operate();
  EXPECT_EQ(taken_over(b).outputs, 0x0081) << "bits 0 and 7: valve and healthy";
}

TEST(StopFrame, carries_the_mode_of_axes_that_are_homing) {
  LoopBench b;
  b.operate();
  b.enable();
  b.channels->commands.push({.kind = CommandKind::Home, .id = 99, .axes = 1u << b.machine.z.value});
  b.ticks(200);
  ASSERT_EQ(b.now.state, State::Homing);
  const WireImage stop = taken_over(b);
  EXPECT_TRUE(stop.is_stop()) << stop.text();
  EXPECT_EQ(stop.axes[3].mode, 6) << "Z homes";
  EXPECT_EQ(stop.axes[0].mode, 8);
}

/// A program that is ended at once while it ends in order: the axes stand, and nothing has taken their torque yet.
TEST(StopFrame, takes_the_torque_of_axes_that_stand_but_of_one_whose_brake_is_open) {
  for (const bool brake : {false, true}) {
    config::Machine machine = reference_machine();
    if (brake) {
      machine.brake.emplace();
      machine.brake->axis = machine.z, machine.brake->bit = 31, machine.brake->time_s = 0.05;
    }
    LoopBench b(machine);
    dispense(b);
    b.channels->commands.push({.kind = CommandKind::Abort, .id = 50});
    int moved = 0;
    for (int n = 0; n < 400; ++n) {
      const WireImage before = b.tap.last_image();
      b.ticks(1);
      const WireImage stop = taken_over(b);
      static_cast<void>(b.stop.take_sent());
      const bool moves = b.tap.last_image().axes[0].target != before.axes[0].target;
      moved += moves;
      EXPECT_TRUE(!moves || stop.is_stop()) << n << ": " << stop.text();
    }
    EXPECT_GT(moved, 20);
    const WireImage last = taken_over(b);
    for (std::size_t i = 0; i < 6; ++i)
      EXPECT_EQ(last.axes[i].control, brake && i == 3 ? kStand : kQuickStop) << i << ": " << last.text();
  }
}

// The segment as the judge: its stations take the bytes through their own FMMUs.
TEST(StopFrame, alone_on_the_bus_it_stops_the_machine_before_the_stations_watchdogs_would) {
  for (const bool last_word : {true, false}) {
    LoopBench b;
    dispense(b);
    ASSERT_TRUE(cycle::send(b.stop));
    auto frame = b.wire.read(1000);
    ASSERT_FALSE(frame.empty());
    const double at = b.segment.motor(b.machine.x).position();
    ASSERT_TRUE(!last_word || b.segment.process(frame));
    b.clock.sleep_until(b.clock.now() + milliseconds(60));  // the stations' watchdogs wait for 100 ms
    b.segment.advance();
    const bool valve = (b.segment.io_outputs(b.io) & 1) != 0;
    EXPECT_EQ(valve, !last_word);
    // What the drives themselves say: statuswords in their inputs, read by a frame that commands nothing new.
    b.tap.forget();
    b.master->exchange(b.clock.now() + milliseconds(1));
    for (const auto& drive : b.setup.drives) {
      const auto status = drive.layout.statusword.get(b.master->inputs(drive.station));
      const bool stands = last_word && !drive.quick_stop_brakes;  // until the station's watchdog takes its torque
      EXPECT_EQ((status & 0x6F) == 0x27, !last_word || stands) << "operation enabled: " << std::hex << status;
      EXPECT_EQ(status & 0x08, 0) << "no fault";
    }
    EXPECT_LT(std::abs(b.segment.motor(b.machine.x).position() - at), 3) << "mm";
  }
}

TEST(StopFrame, its_answer_is_not_taken_for_that_of_an_exchange) {
  LoopBench b;
  dispense(b);
  ASSERT_TRUE(cycle::send(b.stop));
  const auto frame = b.wire.read(1000);
  const auto before = b.master->counters();
  b.port.send(devices::PortIndex::Primary, frame);  // comes back just before the answer that the loop waits for
  b.tick();
  EXPECT_EQ(b.master->counters().late, before.late + 1);
  EXPECT_TRUE(b.now.inputs_fresh);
  EXPECT_EQ(b.master->counters().lost, before.lost);
}

// --- the loop that comes back ----------------------------------------------------------------------------------------

struct Case {
  const char* name;
  std::function<void(LoopBench&)> reach;
  State state;
};

TEST(SpokenFor, the_loop_latches_it_in_every_state_and_never_goes_on_with_the_old_motion) {
  const std::vector<Case> cases{
      {"disabled", [](LoopBench& b) { b.operate(); }, State::Disabled},
      {"enabling",
       [](LoopBench& b) {
         b.operate();
         b.channels->commands.push({.kind = CommandKind::Enable, .id = 50});
         b.ticks(2);
       },
       State::Enabling},
      {"ready", [](LoopBench& b) { b.operate(), b.enable(); }, State::Ready},
      {"homing",
       [](LoopBench& b) {
         b.operate(), b.enable();
         b.channels->commands.push({.kind = CommandKind::Home, .id = 50, .axes = 0x1F});
         b.ticks(150);
       },
       State::Homing},
      {"running", dispense, State::Running},
      {"holding",
       [](LoopBench& b) {
         dispense(b);
         b.channels->commands.push({.kind = CommandKind::Hold, .id = 50});
         b.ticks(5);
       },
       State::Holding},
      {"held",
       [](LoopBench& b) {
         dispense(b);
         b.channels->commands.push({.kind = CommandKind::Hold, .id = 50, .value = 1});
         b.ticks(500);
       },
       State::Held},
  };
  for (const Case& c : cases) {
    LoopBench b;
    c.reach(b);
    ASSERT_EQ(b.now.state, c.state) << c.name;
    const WireImage stop = taken_over(b);
    // The frame is of the cycle before: of what has torque since then it only knows that it may have. Who stands needs
    // no torque to brake.
    const bool torque = c.state == State::Homing || c.state == State::Running || c.state == State::Holding;
    EXPECT_TRUE(torque ? stop.is_stop() : stop.all(kQuickStop)) << c.name << ": " << stop.text();
    const std::uint16_t clamp = b.tap.last_image().outputs & 0x40;
    const bool dispenses = c.state == State::Running || c.state == State::Holding || c.state == State::Held;
    EXPECT_EQ(clamp, dispenses ? 0x40 : 0) << c.name << ": dispense() has shut it";
    b.tap.forget(stop);
    const double at = b.now.actual[0];
    b.tick(60);  // it comes back after 60 ms
    EXPECT_FALSE(b.tap.enabled()) << c.name << ": already the first frame is a stop";
    EXPECT_FALSE(b.tap.opened()) << c.name;
    EXPECT_EQ(b.tap.last_image().outputs & 0x07, 0) << c.name << ": what was switched off stays off";
    b.ticks(500);
    EXPECT_FALSE(b.tap.enabled()) << c.name;
    EXPECT_FALSE(b.tap.opened()) << c.name;
    EXPECT_EQ(b.now.latched, Fault::WatchdogStop) << c.name;
    EXPECT_EQ(b.told(Fault::WatchdogStop), 1) << c.name;
    EXPECT_EQ(b.now.state, State::Stopped) << c.name;
    EXPECT_EQ(b.now.enabled, 0u) << c.name;
    EXPECT_EQ(static_cast<int>(info(b.now.latched).exit_code), 8) << c.name;

    // A reset starts nothing; then the machine can be used again.
    const AxisVec stood = b.now.actual;
    EXPECT_EQ(b.command({.kind = CommandKind::Enable}), Fault::Latched) << c.name;
    EXPECT_EQ(b.command({.kind = CommandKind::Reset}), Fault::None) << c.name;
    b.ticks(500);
    EXPECT_FALSE(b.tap.enabled()) << c.name;
    EXPECT_FALSE(b.tap.opened()) << c.name;
    EXPECT_EQ(b.now.state, State::Disabled) << c.name;
    EXPECT_EQ(b.tap.last_image().outputs & 0x40, clamp) << c.name << ": nobody has opened the clamp";
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(b.now.actual[i], stood[i], 0.01) << c.name << ", axis " << i;
    EXPECT_LT(std::abs(b.now.actual[0] - at), 15) << c.name;
    EXPECT_EQ(b.command({.kind = CommandKind::Enable}), Fault::None) << c.name;
    EXPECT_EQ(b.now.state, State::Ready) << c.name;
  }
}

// The watchdog strikes between the image and its sending: what goes out in that cycle is a stop, too.
TEST(SpokenFor, an_image_that_was_ready_when_the_watchdog_struck_does_not_go_out) {
  LoopBench b;
  dispense(b);
  const auto sent = b.tap.sent();
  WireImage stop = b.tap.last_image();
  for (const std::size_t i : {0u, 3u, 4u, 5u}) stop.axes[i].control = kStand;
  b.tap.forget(stop);
  // The clock is read before the loop sleeps, on waking, then before the exchange.
  b.clock.meddle(3, [&] { EXPECT_TRUE(cycle::send(b.stop)); });
  b.tick();
  ASSERT_FALSE(b.wire.read(0).empty()) << "it struck in this tick";
  EXPECT_EQ(b.tap.sent(), sent + 1);
  EXPECT_FALSE(b.tap.enabled()) << b.tap.last_image().text();
  EXPECT_FALSE(b.tap.opened());
  EXPECT_EQ(b.now.latched, Fault::None) << "told in the next";
  b.tick();
  EXPECT_EQ(b.now.latched, Fault::WatchdogStop);
  EXPECT_FALSE(b.tap.enabled());
  EXPECT_FALSE(b.tap.opened());
}

// It strikes in the exchange itself: that frame is with the system, and nobody can take it back. The next one is a
// stop.
TEST(SpokenFor, a_frame_that_was_on_its_way_when_the_watchdog_struck_is_the_last_of_the_old_motion) {
  LoopBench b;
  dispense(b);
  b.clock.meddle(4, [&] {
    EXPECT_TRUE(b.stop.exchanging());
    EXPECT_TRUE(cycle::send(b.stop));
  });
  b.tick();
  const auto stop = decode_cyclic(b.wire.read(0));
  ASSERT_TRUE(stop) << "it struck in this tick";
  b.tap.forget(*stop);
  b.ticks(200);
  EXPECT_EQ(b.now.latched, Fault::WatchdogStop);
  EXPECT_FALSE(b.tap.enabled());
  EXPECT_FALSE(b.tap.opened());
}

}  // namespace
}  // namespace gantry::test
