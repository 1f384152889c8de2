// A reset and a disable that come in one cycle, behind a stop that has left the drives their torque.
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

}  // namespace
}  // namespace gantry
