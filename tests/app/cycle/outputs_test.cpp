// What the loop's outputs say by themselves: the stack light, the pulse that says the machine is healthy, and the
// valve, which no order for outputs opens. Read from the bus, not from what the loop says of it.
#include "app/job/limits.hpp"
#include "devices/can_port.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

using cycle::CommandKind;
using cycle::State;
using test::LoopBench;

enum class Light { Dark, Red, Yellow, Green, Several };

struct Lit : LoopBench {
  Lit() { operate(); }
  [[nodiscard]] bool on(config::Output output) const {
    const config::Channel& channel = *machine.outputs[static_cast<std::size_t>(output)];
    return (segment.io_outputs(channel.station) >> channel.bit & 1u) != 0;
  }
  [[nodiscard]] Light light() const {
    const bool red = on(config::Output::StackRed), yellow = on(config::Output::StackYellow),
               green = on(config::Output::StackGreen);
    if (red + yellow + green > 1) return Light::Several;
    return red ? Light::Red : yellow ? Light::Yellow : green ? Light::Green : Light::Dark;
  }
  /// Of an input's bit.
  void set(config::Input input, bool high) {
    const unsigned bit = machine.inputs[static_cast<std::size_t>(input)]->bit;
    levels_ = high ? levels_ | 1u << bit : levels_ & ~(1u << bit);
    segment.set_io_inputs(io, static_cast<std::uint16_t>(levels_));
    ticks(20);
  }
  /// On and off, in so many cycles, one by one: how often it changed.
  int changes(config::Output output, int cycles) {
    int count = 0;
    for (bool before = on(output); cycles > 0; --cycles) {
      tick();
      count += on(output) != before ? 1 : 0;
      before = on(output);
    }
    return count;
  }

 private:
  unsigned levels_ = 0xFFFF;
};

TEST(StackLight, is_red_in_a_fault_yellow_without_torque_or_on_hold_and_green_when_ready_or_at_work) {
  Lit b;
  EXPECT_EQ(b.light(), Light::Yellow) << "without torque";
  b.enable();
  b.ticks(5);
  EXPECT_EQ(b.light(), Light::Green) << "ready";
  b.home();
  AxisVec to = b.now.target;
  to[0] += 100;
  b.play(motion::line_move(job::limits_of(b.machine), b.now.target, to));
  b.ticks(100);
  ASSERT_EQ(b.now.state, State::Running);
  EXPECT_EQ(b.light(), Light::Green);
  ASSERT_EQ(b.command({.kind = CommandKind::Hold}), Fault::None);
  ASSERT_TRUE(b.until([&] { return b.now.state == State::Held; }, 1000));
  b.ticks(5);
  EXPECT_EQ(b.light(), Light::Yellow) << "it goes on when somebody resumes it";
  b.set(config::Input::Stop, false);
  EXPECT_EQ(b.light(), Light::Red);
  b.set(config::Input::Stop, true);
  EXPECT_EQ(b.light(), Light::Red) << "until somebody resets";
  ASSERT_EQ(b.command({.kind = CommandKind::Reset}), Fault::None);
  b.ticks(5);
  EXPECT_EQ(b.light(), Light::Green);
}

TEST(StackLight, is_yellow_while_a_job_waits_between_two_blocks_for_a_resume) {
  Lit b;
  b.enable();
  b.channels->on_hold = true;
  b.ticks(5);
  EXPECT_EQ(b.now.state, State::Ready);
  EXPECT_EQ(b.light(), Light::Yellow);
  b.channels->on_hold = false;
  b.ticks(5);
  EXPECT_EQ(b.light(), Light::Green);
}

TEST(StackLight, is_yellow_in_setup) {
  Lit b;
  b.enable();
  b.ticks(5);
  ASSERT_EQ(b.light(), Light::Green);
  b.set(config::Input::Mode, false);
  EXPECT_EQ(b.light(), Light::Yellow);
}

// A pulse of 100 ms, so that whoever watches it notices an output that is stuck, and a program that is.
TEST(Healthy, beats_while_nothing_is_latched) {
  Lit b;
  b.enable();
  EXPECT_NEAR(b.changes(config::Output::Healthy, 1000), 20, 1);
  b.set(config::Input::Stop, false);
  ASSERT_NE(b.now.latched, Fault::None);
  EXPECT_EQ(b.changes(config::Output::Healthy, 1000), 0);
  EXPECT_FALSE(b.on(config::Output::Healthy));
  b.set(config::Input::Stop, true);
  ASSERT_EQ(b.command({.kind = CommandKind::Reset}), Fault::None);
  EXPECT_NEAR(b.changes(config::Output::Healthy, 1000), 20, 1);
}

TEST(Outputs, an_order_for_all_of_them_opens_no_valve) {
  Lit b;
  b.enable();
  ASSERT_EQ(b.command({.kind = CommandKind::SetOutputs, .mask = 0xFFFF'FFFF, .bits = 0xFFFF'FFFF}), Fault::None);
  for (int i = 0; i < 200; ++i) {
    b.tick();
    ASSERT_FALSE(b.on(config::Output::Valve));
  }
  EXPECT_TRUE(b.on(config::Output::CameraLight)) << "the order was obeyed";
}

/// Takes nothing from some cycle on.
class FullPort final : public devices::CanPort {
 public:
  bool full = false;
  bool send(const devices::CanFrame&) noexcept override { return !full; }
  bool receive(devices::CanFrame&, Time) noexcept override { return false; }
};

TEST(CanBus, that_takes_no_frames_is_named) {
  FullPort can;
  LoopBench c;
  c.loop = std::make_unique<cycle::Loop>(c.setup, *c.master, &can, c.clock, *c.channels, &c.stop);
  c.operate();
  c.enable();
  EXPECT_EQ(c.told(Fault::CanBusDown), 0);
  can.full = true;
  c.ticks(100);
  EXPECT_EQ(c.told(Fault::CanBusDown), 1);
}

}  // namespace
}  // namespace gantry
