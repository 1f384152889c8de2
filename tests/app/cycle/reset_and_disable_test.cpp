// A reset and a disable that come in one cycle, behind a stop that has left the drives their torque.
#include <cmath>
#include <utility>

#include "app/job/limits.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

using cycle::CommandKind;
using cycle::State;
using test::LoopBench;

TEST(ResetAndDisable, end_without_torque_and_in_a_state_that_says_so) {
  for (const bool reset_first : {true, false})
    for (const int apart : {0, 1, 2, 5}) {
      SCOPED_TRACE(testing::Message() << (reset_first ? "reset" : "disable") << " first, cycles apart: " << apart);
      LoopBench b;
      b.operate();
      b.enable();
      const auto door = *b.machine.inputs[static_cast<std::size_t>(config::Input::DoorClosed)];
      const std::uint16_t levels = 0xFFFF;
      b.segment.set_io_inputs(b.io, static_cast<std::uint16_t>(levels & ~(1u << door.bit)));
      ASSERT_TRUE(b.until([&] { return b.now.state == State::Stopped; }, 100));
      b.segment.set_io_inputs(b.io, levels);
      b.ticks(100);
      ASSERT_EQ(b.now.enabled, 0b11111u) << "a path stop leaves the torque";

      for (const bool first : {true, false}) {
        const auto kind = first == reset_first ? CommandKind::Reset : CommandKind::Disable;
        ASSERT_TRUE(b.channels->commands.push({.kind = kind, .id = ++b.last_id}));
        if (first) b.ticks(apart);
      }
      b.ticks(500);
      EXPECT_EQ(b.now.enabled, 0u);
      EXPECT_EQ(b.now.latched, Fault::None);
      EXPECT_EQ(b.now.state, State::Disabled);
      b.enable();
      EXPECT_EQ(b.now.state, State::Ready);
      EXPECT_EQ(b.now.enabled, 0b11111u);
    }
}

/// Three frames are lost while the axis that lags most goes at full speed: it still moves when the machine is stopped.
struct SettlingAxis : LoopBench {
  static constexpr AxisId kY{1};
  SettlingAxis() {
    operate();
    enable();
    home();
    AxisVec to = now.target;
    to[kY.value] = 390;
    play(motion::line_move(job::limits_of(machine), now.target, to));
    while (now.target[kY.value] < 200) step();
    segment.lose_frames(3);
    for (int i = 0; i < 100 && (now.state != State::Stopped || !now.answered); ++i) step();
    EXPECT_EQ(now.latched, Fault::FramesLost);
  }
  void step() {
    tick();
    const double here = segment.motor(kY, 0).position();
    speed_mm_s = std::abs(here - std::exchange(before_, here)) / 0.001;
  }
  void order(CommandKind kind) { ASSERT_TRUE(channels->commands.push({.kind = kind, .id = ++last_id})); }
  [[nodiscard]] bool has_torque() const { return (now.enabled >> kY.value & 1u) != 0; }

  double speed_mm_s = 0;  ///< of the motor

 private:
  double before_ = 0;
};

TEST(ResetAndDisable, take_no_torque_from_an_axis_that_still_moves) {
  double fastest = 0;
  for (const bool reset : {false, true})
    for (const int after : {0, 1, 2, 5, 10, 40}) {
      SCOPED_TRACE(testing::Message() << (reset ? "behind a reset, " : "") << after << " cycles later");
      SettlingAxis b;
      if (reset) b.order(CommandKind::Reset);
      for (int i = 0; i < after; ++i) b.step();
      fastest = std::max(fastest, b.speed_mm_s);
      b.order(CommandKind::Disable);
      for (int i = 0; i < 4000 && b.has_torque(); ++i) b.step();
      EXPECT_LT(b.speed_mm_s, 1) << "as it gives up its torque";
      b.ticks(100);
      EXPECT_EQ(b.now.enabled, 0u);
      EXPECT_EQ(b.now.state, reset ? State::Disabled : State::Stopped);
      EXPECT_EQ(b.now.referenced, 0b11111u);
    }
  EXPECT_GT(fastest, 100) << "all stood already, and this shows nothing";
}

/// Ready is a machine that stands; and how far an axis is behind a target that has been stopped short is no fault of
/// its own.
TEST(ResetAndDisable, a_reset_waits_for_an_axis_that_still_moves) {
  SettlingAxis b;
  EXPECT_GT(b.speed_mm_s, 100);
  b.order(CommandKind::Reset);
  for (int i = 0; i < 500 && b.now.state != State::Ready; ++i) b.step();
  ASSERT_EQ(b.now.state, State::Ready);
  EXPECT_LT(b.speed_mm_s, 1);
  b.ticks(100);
  EXPECT_EQ(b.now.state, State::Ready);
  EXPECT_EQ(b.now.latched, Fault::None);
  EXPECT_EQ(b.now.enabled, 0b11111u);
}

}  // namespace
}  // namespace gantry
