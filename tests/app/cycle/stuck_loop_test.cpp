// R62 with everything real but the cable: the loop in its thread, its watchdog in another, and an exchange that does
// not return, as of a driver that hangs. Real time; what must come is waited for.
#include <cstdio>
#include <thread>

#include "app/cycle/thread.hpp"
#include "app/run/control.hpp"
#include "app/stations/fault_words.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry::test {
namespace {

using cycle::CommandKind;
using cycle::State;

constexpr int kPatience_ms = 20'000;
constexpr std::uint16_t kQuickStop = 0x0002;  // CiA 402, command coding

struct RunningLoop {
  RunningLoop() {
    loop = std::make_unique<cycle::Loop>(setup, master, nullptr, clock, *channels, &stop);
    feed.listen({}, [this](const cycle::Event& e) { events.push_back(e); });
  }
  ~RunningLoop() { tap.hold_up = false; }

  void operate() {
    const auto up = master.bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
    const auto door = *machine.inputs[static_cast<std::size_t>(config::Input::DoorClosed)];
    segment.set_io_inputs(door.station, 0xFFFF);
    thread.emplace(*loop, clock, *channels, master.first_cycle(clock.now() + milliseconds(5)));
    ASSERT_TRUE(control.pass(0.02));
    ASSERT_TRUE(master.request_operation());
    ASSERT_TRUE(control.wait([&] { return control.latest().state == State::Disabled; }, 20, {}));
    ASSERT_TRUE(control.pass(0.5));
    ASSERT_TRUE(control.command({.kind = CommandKind::Enable}, 20));
    const std::uint32_t on = config::bit(config::Output::CameraLight) | config::bit(config::Output::Clamp);
    ASSERT_TRUE(control.command({.kind = CommandKind::SetOutputs, .mask = on, .bits = on}, 20));
    ASSERT_TRUE(control.pass(0.01));
  }

  config::Machine machine = reference_machine();
  MonotonicClock clock;
  sim::Segment segment{machine, clock};
  sim::SegmentPort port{segment, clock};
  TwoEnds wire;
  TapPort tap{port, wire.in()};
  devices::EthercatMaster master{machine, tap, clock};
  std::unique_ptr<cycle::Channels> channels = std::make_unique<cycle::Channels>();
  cycle::LoopSetup setup =
      run::compose_loop(machine, run::Host::WallClock).value();  // 50 cycles: the host is no controller
  cycle::StopFrame stop{setup, tap.descriptor()};
  std::unique_ptr<cycle::Loop> loop;
  run::Feed feed{*channels};
  run::RealPump pump{clock, machine.bus.cycle};
  run::Control control{*channels, feed, pump, machine.bus.cycle,
                       [this](const cycle::Event& e) { return stations::in_words(machine, e); }};
  std::vector<cycle::Event> events;
  std::optional<cycle::LoopThread> thread;
};

TEST(StuckLoop, its_watchdog_speaks_and_the_loop_that_comes_back_has_stopped) {
  RunningLoop b;
  b.operate();
  if (HasFatalFailure()) return;
  cycle::Watchdog dog(b.stop, b.clock, b.setup.stuck_after());

  b.tap.hold_up = true;
  const auto frame = b.wire.read(kPatience_ms);
  const Time heard = b.clock.now();
  const auto stop = decode_cyclic(frame);
  ASSERT_TRUE(stop) << "no stop frame";
  const WireImage last = b.tap.last_image();  // the loop stands in its exchange
  EXPECT_TRUE(last.all(0x000F)) << last.text();
  EXPECT_TRUE(stop->all(kQuickStop)) << "who stands needs no torque to brake: " << stop->text();
  EXPECT_TRUE(stop->rests()) << stop->text();
  EXPECT_TRUE(stop->clamp()) << "operate() has shut it: " << stop->text();
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(stop->axes[i].target, last.axes[i].target) << i;
  const int sent = b.tap.sent();
  std::printf("the stop frame was there %.3f ms after the last beat; the bound is %.0f ms\n",
              1e3 * seconds(heard - b.stop.last_beat()), 1e3 * seconds(b.setup.stuck_after()));
  EXPECT_GE(heard - b.stop.last_beat(), b.setup.stuck_after());
  EXPECT_TRUE(b.wire.read(100).empty()) << "once";
  EXPECT_EQ(b.tap.sent(), sent) << "and nothing from the loop";

  b.tap.forget(*stop);
  b.tap.hold_up = false;
  const auto why = b.control.wait([] { return false; }, 20, {});
  ASSERT_FALSE(why);
  EXPECT_EQ(why.error().fault, Fault::WatchdogStop) << to_text(why.error());
  EXPECT_NE(why.error().message.find(" ms)"), std::string::npos) << why.error().message;
  for (int i = 0; i < 300; ++i) b.control.step();
  EXPECT_FALSE(b.tap.enabled());
  EXPECT_FALSE(b.tap.opened());
  EXPECT_EQ(b.control.latest().state, State::Stopped);
  EXPECT_EQ(b.control.latest().latched, Fault::WatchdogStop);
  EXPECT_TRUE(b.thread->join());
}

TEST(StuckLoop, one_that_never_comes_back_is_given_up) {
  RunningLoop b;
  b.operate();
  if (HasFatalFailure()) return;
  b.tap.hold_up = true;
  const auto why = b.control.wait([] { return false; }, 3600, {});
  ASSERT_FALSE(why);
  EXPECT_EQ(why.error().fault, Fault::LoopDied) << to_text(why.error());
  EXPECT_FALSE(b.control.command({.kind = CommandKind::Reset}, 3600)) << "and nobody waits for its answers";
  b.control.post({.kind = CommandKind::Disable});
  EXPECT_FALSE(b.thread->join()) << "it hangs";
  b.tap.hold_up = false;
  EXPECT_TRUE(b.thread->join());
}

}  // namespace
}  // namespace gantry::test
