// A station that somebody has taken out of OP and put back: its drive has stopped in order and shows no fault.
#include <algorithm>

#include "app/job/limits.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/wire/ethercat.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

using cycle::State;
using devices::DriveState;
using test::LoopBench;

constexpr std::size_t kY2 = 3, kZ = 4;  // on the line

struct FallenBench : LoopBench {
  explicit FallenBench(config::Machine m = test::reference_machine()) : LoopBench(std::move(m)) {
    operate();
    enable();
    home();
    EXPECT_EQ(now.enabled, 0b11111u);
  }
  /// As another master would, or the drive's own panel.
  void ask(devices::wire::AlState state, std::size_t station = kZ) {
    devices::Link link(port, clock);
    const auto asked = link.write<std::uint16_t>(master->stations()[station].address, devices::wire::reg::kAlControl,
                                                 static_cast<std::uint16_t>(state));
    ASSERT_TRUE(asked) << to_text(asked.error());
  }
  [[nodiscard]] bool z_enabled() const { return (now.enabled >> machine.z.value & 1u) != 0; }
};

TEST(FallenDrive, a_drive_whose_station_was_out_of_op_is_not_enabled_again_by_its_return) {
  FallenBench b;
  b.ask(devices::wire::AlState::SafeOp);
  b.ticks(500);
  EXPECT_EQ(b.now.al_states, 12);
  EXPECT_EQ(b.now.working_counter, b.now.expected);
  EXPECT_EQ(b.now.latched, Fault::StationLeftOp);
  EXPECT_FALSE(b.z_enabled());
  EXPECT_EQ(b.now.enabled, 0b11111u & ~(1u << b.machine.z.value)) << "the others hold their positions";
  b.ask(devices::wire::AlState::Op);
  for (int i = 0; i < 2000; ++i) {
    b.tick();
    ASSERT_FALSE(b.z_enabled()) << i;
  }
  EXPECT_EQ(b.now.al_states, 8);
  EXPECT_EQ(b.now.state, State::Stopped);
  EXPECT_EQ(b.command({.kind = cycle::CommandKind::Reset}), Fault::None);
  b.ticks(1000);
  EXPECT_EQ(b.now.state, State::Disabled);
  EXPECT_FALSE(b.z_enabled());
  b.enable();
  EXPECT_TRUE(b.z_enabled());
}

TEST(FallenDrive, a_drive_that_leaves_operation_enabled_by_itself_stops_the_machine_and_says_so) {
  FallenBench b;
  b.segment.drive_fault(b.machine.z, 0, 0x400);  // the emergency input of an iD286: a warning, and no torque
  b.ticks(300);
  EXPECT_EQ(b.now.state, State::Stopped);
  EXPECT_FALSE(b.z_enabled());
  EXPECT_EQ(b.told(Fault::DriveDropped), 0) << "the input itself is what is told";
}

/// STD402EC counts its commands: where its motor came to stand without torque, nobody knows. An axis that stood, and
/// one with an encoder, keep theirs.
TEST(FallenDrive, an_open_loop_axis_that_loses_its_torque_in_motion_is_not_referenced_any_more) {
  struct Case {
    const char* axis;
    bool moves;
    bool keeps;
  };
  for (const Case& c : {Case{"C", true, false}, Case{"C", false, true}, Case{"X", true, true}}) {
    SCOPED_TRACE(testing::Message() << c.axis << (c.moves ? " moves" : " stands"));
    FallenBench b;
    const auto axis = std::find_if(b.machine.axes.begin(), b.machine.axes.end(),
                                   [&](const config::Axis& a) { return a.name == c.axis; });
    ASSERT_NE(axis, b.machine.axes.end());
    if (c.moves) {
      AxisVec to = b.now.target;
      to[axis->id.value] += axis->rotary ? 1.5 : 100;
      b.play(motion::line_move(job::limits_of(b.machine), b.now.target, to));
      b.ticks(150);
      ASSERT_EQ(b.now.state, State::Running);
    }
    b.segment.drive_fault(axis->id, 0, c.axis[0] == 'C' ? 0x8611 : 0x400);
    b.ticks(500);
    EXPECT_EQ(b.now.enabled >> axis->id.value & 1u, 0u);
    EXPECT_EQ(b.now.referenced, c.keeps ? 0b11111u : 0b11111u & ~(1u << axis->id.value));
  }
}

/// What moves it then, nobody sees: a hand at the needle, a lift that sinks. Its motor is held by nothing but itself.
TEST(FallenDrive, an_open_loop_axis_that_stands_without_torque_is_not_referenced_unless_something_holds_it) {
  struct Case {
    const char* what;
    bool self_locking, braked;
  };
  for (const Case& c : {Case{"nothing", false, false}, Case{"its screw", true, false}, Case{"a brake", false, true}}) {
    SCOPED_TRACE(c.what);
    config::Machine m = test::reference_machine();
    for (config::Axis& axis : m.axes)
      if (axis.name == "U") axis.self_locking = c.self_locking;
    if (c.braked) m.brake = config::BrakeConfig{.axis = *m.u, .bit = 15, .time_s = 0.05, .release_s = 0.05};
    FallenBench b(m);
    b.ticks(200);
    ASSERT_EQ(b.command({.kind = cycle::CommandKind::Disable}), Fault::None);
    b.ticks(10);
    const std::uint32_t lift = 1u << m.u->value;
    EXPECT_EQ(b.now.referenced, c.self_locking || c.braked ? 0b11111u : 0b11111u & ~lift);
    b.enable();
    EXPECT_EQ((b.now.referenced & lift) != 0, c.self_locking || c.braked);
  }
}

/// It brakes by its own ramp, whether its outputs are still taken or not; so does the other side. Judged by the motors.
/// (In INIT the simulated drive has no torque and is not heard: nobody can run out beside it.)
TEST(FallenDrive, one_side_of_a_beam_takes_the_other_along_wherever_its_station_is_taken) {
  using devices::wire::AlState;
  for (const AlState state : {AlState::SafeOp, AlState::PreOp}) {
    SCOPED_TRACE(static_cast<int>(state));
    FallenBench b;
    AxisVec to = b.now.target;
    to[1] = 390;
    b.play(motion::line_move(job::limits_of(b.machine), b.now.target, to));
    ASSERT_TRUE(b.until([&] { return b.now.target[1] > 150; }, 2000));
    b.ask(state, kY2);
    double apart = 0;
    const auto side = [&](int drive) { return b.segment.motor(AxisId{1}, drive).position(); };
    for (int i = 0; i < 500; ++i) {
      b.tick();
      apart = std::max(apart, std::abs(side(0) - side(1)));
    }
    EXPECT_LT(apart, 3) << "mm: some cycles at 500 mm/s";
    EXPECT_EQ(b.now.state, State::Stopped);
    EXPECT_EQ(b.now.enabled >> 1 & 1u, 0u);
  }
}

}  // namespace
}  // namespace gantry
