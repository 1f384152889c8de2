// A counter that jumps voids the reference of its axis, whatever else is wrong and whatever the loop makes of that.
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

using cycle::State;
using test::LoopBench;

struct JumpBench : LoopBench {
  JumpBench() {
    operate();
    enable();
    home();
    EXPECT_EQ(now.referenced & kAll, kAll);
  }
  /// The drive's counter is another one from the next sample on; the motor stands where it stood.
  void jump(AxisId axis, double by = 5) {
    sim::DriveMemory memory = segment.memory(axis);
    memory.count_zero += by;
    segment.restore(axis, 0, memory);
  }
  [[nodiscard]] std::uint32_t bit(AxisId axis) const { return 1u << axis.value; }
  static constexpr std::uint32_t kAll = 0b11111u;
};

TEST(EncoderJump, alone_stops_the_machine_and_voids_the_reference_of_its_axis_only) {
  JumpBench b;
  b.jump(b.machine.z);
  b.ticks(3);
  EXPECT_EQ(b.told(Fault::EncoderJump), 1);
  EXPECT_EQ(b.now.referenced & JumpBench::kAll, JumpBench::kAll & ~b.bit(b.machine.z));
}

TEST(EncoderJump, in_the_cycle_of_a_drive_fault_voids_the_reference_too) {
  JumpBench b;
  b.segment.drive_fault(b.machine.z, 0, 0x000A);
  b.jump(b.machine.z);
  b.ticks(3);
  EXPECT_NE(b.now.latched, Fault::None);
  EXPECT_EQ(b.now.referenced & JumpBench::kAll, JumpBench::kAll & ~b.bit(b.machine.z));
}

TEST(EncoderJump, behind_a_latched_fault_voids_the_reference_and_a_reset_does_not_bring_it_back) {
  JumpBench b;
  const AxisId other = config::find_axis(b.machine, "X")->id;
  b.segment.drive_fault(other, 0, 0x000A);
  b.ticks(300);
  ASSERT_EQ(b.now.state, State::Stopped);
  ASSERT_EQ(b.now.referenced & JumpBench::kAll, JumpBench::kAll);
  b.jump(b.machine.z);
  b.ticks(3);
  EXPECT_EQ(b.now.referenced & JumpBench::kAll, JumpBench::kAll & ~b.bit(b.machine.z));
  b.command({.kind = cycle::CommandKind::Reset});
  b.ticks(1000);
  EXPECT_EQ(b.now.referenced & b.bit(b.machine.z), 0u);
}

}  // namespace
}  // namespace gantry
