// A brake that the machine itself works: released while its axis has torque, closed before the torque goes. The judge
// is what the I/O station puts out, beside the statusword that the drive shows in the same cycle (IEC 61800-7-201,
// table 29: Operation Enabled is x01x 0111).
#include <algorithm>

#include "app/job/limits.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry::test {
namespace {

using cycle::CommandKind;

constexpr std::uint8_t kBit = 9;
constexpr int kBrakeCycles = 60, kReleaseCycles = 150;

config::Machine with_brake() {
  config::Machine m = reference_machine();
  const StationId io = m.outputs[static_cast<std::size_t>(config::Output::Healthy)]->station;
  m.free_outputs.push_back({"z_brake", {io, kBit, false}});
  m.brake = {.axis = m.z,
             .bit = static_cast<unsigned>(config::kOutputs + m.free_outputs.size() - 1),
             .time_s = 0.06,
             .release_s = 0.15};
  return m;
}

struct Sample {
  bool released = false, torque = false;
  double z = 0;
};

struct Braked : LoopBench {
  Braked() : LoopBench(with_brake()) {
    operate();
    z_drive = static_cast<std::size_t>(std::ranges::find(setup.drives, machine.z, &cycle::DriveSetup::axis) -
                                       setup.drives.begin());
  }
  void watch(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      tick();
      samples.push_back({(segment.io_outputs(io) >> kBit & 1u) != 0,
                         (now.statusword[z_drive] & 0x6F) == 0x27 || (now.statusword[z_drive] & 0x6F) == 0x07,
                         now.actual[machine.z.value]});
    }
  }
  void post(cycle::Command c) {
    c.id = ++last_id;
    ASSERT_TRUE(channels->commands.push(c));
  }
  [[nodiscard]] int last(bool Sample::*what) const {
    const auto it = std::find_if(samples.rbegin(), samples.rend(), [&](const Sample& s) { return s.*what; });
    return static_cast<int>(samples.rend() - it) - 1;
  }
  [[nodiscard]] int first(bool Sample::*what) const {
    return static_cast<int>(std::ranges::find(samples, true, what) - samples.begin());
  }
  /// From when on Z has not moved, in watched cycles.
  [[nodiscard]] int stood() const {
    int from = static_cast<int>(samples.size()) - 1;
    while (from > 0 && std::abs(samples[static_cast<std::size_t>(from - 1)].z - samples.back().z) < 2e-3) --from;
    return from;
  }

  std::size_t z_drive = 0;
  std::vector<Sample> samples;
};

TEST(Brake, is_released_when_its_axis_has_torque_and_not_before) {
  Braked b;
  if (HasFatalFailure()) return;
  b.watch(50);
  EXPECT_EQ(b.last(&Sample::released), -1);
  b.post({.kind = CommandKind::Enable});
  b.watch(1500);
  ASSERT_GE(b.last(&Sample::released), 0);
  EXPECT_GE(b.first(&Sample::released), b.first(&Sample::torque));
  EXPECT_LE(b.first(&Sample::released), b.first(&Sample::torque) + 2);
  EXPECT_TRUE(b.samples.back().released);
}

TEST(Brake, holds_before_an_order_takes_the_torque) {
  Braked b;
  if (HasFatalFailure()) return;
  b.enable();
  b.ticks(200);
  b.post({.kind = CommandKind::Disable});
  b.watch(300);
  EXPECT_LE(b.last(&Sample::released), 2) << "it closes at once";
  EXPECT_GE(b.last(&Sample::torque), b.last(&Sample::released) + kBrakeCycles);
  EXPECT_LE(b.last(&Sample::torque), b.last(&Sample::released) + kBrakeCycles + 10);
}

/// Between the order and the end of the torque the brake closes.
TEST(Brake, a_fault_while_an_order_takes_the_torque_is_the_answer_to_it) {
  for (const bool faults : {false, true}) {
    Braked b;
    if (HasFatalFailure()) return;
    b.enable();
    b.ticks(200);
    b.post({.kind = CommandKind::Disable});
    b.watch(10);
    if (faults) b.segment.drive_fault(AxisId{3}, 0, 0x3220);  // undervoltage of C (G213)
    b.watch(500);
    const auto answer = std::ranges::find_if(
        b.events, [&](const cycle::Event& e) { return e.kind == cycle::EventKind::CommandDone && e.id == b.last_id; });
    ASSERT_NE(answer, b.events.end());
    EXPECT_EQ(answer->fault, faults ? Fault::Undervoltage : Fault::None);
    EXPECT_EQ(b.now.enabled, 0u) << "either way";
    EXPECT_FALSE(b.samples.back().torque);
  }
}

TEST(Brake, closes_when_its_axis_stands_and_holds_before_a_stop_takes_the_torque) {
  Braked b;
  if (HasFatalFailure()) return;
  b.enable();
  b.home();
  AxisVec to = b.now.target;
  to[b.machine.z.value] = -60;
  b.play(motion::line_move(job::limits_of(b.machine), b.now.target, to));
  b.watch(250);
  const double speed = (b.samples[249].z - b.samples[239].z) / 0.010;
  ASSERT_LT(speed, -50) << "it moves down";
  b.samples.clear();
  b.segment.drive_fault(AxisId{3}, 0, 0x3220);  // undervoltage of C: a quick stop of all (G213)
  b.watch(1500);
  EXPECT_EQ(b.now.latched, Fault::Undervoltage);
  EXPECT_LT(b.samples.back().z, b.samples.front().z - 1) << "it has braked, not stopped dead";
  EXPECT_GE(b.last(&Sample::released), b.stood() - 3);
  EXPECT_GE(b.last(&Sample::torque), b.last(&Sample::released) + kBrakeCycles);
  EXPECT_FALSE(b.samples.back().torque);
}

TEST(Brake, closes_at_once_where_its_own_drive_has_lost_its_torque) {
  Braked b;
  if (HasFatalFailure()) return;
  b.enable();
  b.ticks(100);
  b.segment.drive_fault(b.machine.z, 0, 0x000A);
  b.watch(300);
  EXPECT_LE(b.last(&Sample::released), b.last(&Sample::torque) + 2);
  EXPECT_FALSE(b.samples.back().released);
}

// A reset takes the torque of all drives where one has lost its own.
TEST(Brake, holds_before_a_reset_takes_the_torque) {
  Braked b;
  if (HasFatalFailure()) return;
  b.enable();
  b.ticks(100);
  b.segment.drive_fault(AxisId{3}, 0, 0x0010);  // C: Z keeps its torque
  b.ticks(200);
  ASSERT_NE(b.now.latched, Fault::None);
  b.watch(10);
  ASSERT_TRUE(b.samples.back().torque && b.samples.back().released);
  b.samples.clear();
  b.post({.kind = CommandKind::Reset});
  b.watch(600);
  EXPECT_FALSE(b.samples.back().torque);
  EXPECT_LE(b.last(&Sample::released), 2);
  EXPECT_GE(b.last(&Sample::torque), b.last(&Sample::released) + kBrakeCycles);
  EXPECT_LE(b.last(&Sample::torque), b.last(&Sample::released) + kBrakeCycles + 10);
}

TEST(Brake, holds_before_the_torque_goes_also_where_a_fault_comes_while_it_closes) {
  Braked b;
  if (HasFatalFailure()) return;
  b.enable();
  b.ticks(100);
  b.post({.kind = CommandKind::Disable});
  b.watch(10);
  b.segment.drive_fault(AxisId{3}, 0, 0x0010);
  b.watch(200);
  EXPECT_LE(b.last(&Sample::released), 2);
  EXPECT_GE(b.last(&Sample::torque), b.last(&Sample::released) + kBrakeCycles);
  EXPECT_FALSE(b.samples.back().torque);
}

TEST(Brake, the_machine_is_not_ready_before_it_is_open) {
  Braked b;
  if (HasFatalFailure()) return;
  b.post({.kind = CommandKind::Enable});
  int released = 0;
  for (int i = 0; i < 3000 && b.now.state != cycle::State::Ready; ++i) {
    b.watch(1);
    released += b.samples.back().released ? 1 : 0;
  }
  EXPECT_EQ(b.now.state, cycle::State::Ready);
  EXPECT_GE(released, kReleaseCycles);
  EXPECT_LE(released, kReleaseCycles + 3);
}

// The record of a stall would else tell of a brake that closed, and of lamps that went out. "healthy" is a square wave
// of 100 ms of the machine's clock.
TEST(Brake, is_told_as_it_is_in_cycles_that_a_stall_has_skipped) {
  Braked b;
  if (HasFatalFailure()) return;
  b.enable();
  b.ticks(400);
  const std::uint32_t healthy = config::bit(config::Output::Healthy);
  const std::uint32_t others = b.now.outputs & ~healthy;
  ASSERT_NE(others & 1u << b.machine.brake->bit, 0u);
  ASSERT_NE(others & b.setup.lamp_masks[static_cast<std::size_t>(cycle::Lamp::Green)], 0u);
  for (int i = 0; i < 30; ++i) {
    b.tick(3);
    b.ticks(60);  // late cycles that are as far apart stop nothing
  }
  ASSERT_EQ(b.now.state, cycle::State::Ready);
  ASSERT_GE(b.skipped.size(), 30u);
  int on = 0;
  for (const cycle::Snapshot& s : b.skipped) {
    EXPECT_EQ(s.outputs & ~healthy, others) << "cycle " << s.cycle;
    EXPECT_EQ((s.outputs & healthy) != 0, s.cycle / 50 % 2 == 0) << "cycle " << s.cycle;
    on += (s.outputs & healthy) != 0;
  }
  EXPECT_GT(on, 0);
  EXPECT_LT(on, static_cast<int>(b.skipped.size()));
}

// What goes against gravity has sunk when the brake holds later than the machine file says, and that is told once.
TEST(Brake, that_holds_later_than_it_should_is_told) {
  for (const bool late : {false, true}) {
    Braked b;
    if (HasFatalFailure()) return;
    b.enable();
    b.ticks(200);
    if (late) b.segment.motor(b.machine.z).set_slipping(-50);  // mm/s, without torque
    b.post({.kind = CommandKind::Disable});
    b.watch(kBrakeCycles + 20 + 60);
    b.segment.motor(b.machine.z).set_slipping(0);
    b.watch(800);
    EXPECT_FALSE(b.samples.back().torque);
    EXPECT_EQ(b.told(Fault::BrakeDrift), late ? 1 : 0);
  }
}

TEST(Brake, is_not_worked_by_an_order_for_outputs) {
  Braked b;
  if (HasFatalFailure()) return;
  const std::uint32_t bit = 1u << b.machine.brake->bit;
  EXPECT_EQ(b.command({.kind = CommandKind::SetOutputs, .mask = bit, .bits = bit}), Fault::None);
  b.watch(100);
  EXPECT_EQ(b.last(&Sample::released), -1) << "without torque it stays closed";
  b.enable();
  b.ticks(20);
  EXPECT_EQ(b.command({.kind = CommandKind::SetOutputs, .mask = bit, .bits = 0}), Fault::None);
  b.samples.clear();
  b.watch(100);
  EXPECT_EQ(b.first(&Sample::released), 0);
  EXPECT_EQ(b.last(&Sample::released), 99) << "with torque it stays released";
}

}  // namespace
}  // namespace gantry::test
