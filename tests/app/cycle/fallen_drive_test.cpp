// A station that somebody has taken out of OP and put back: its drive has stopped in order and shows no fault.
#include "devices/ethercat/link.hpp"
#include "devices/wire/ethercat.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

using cycle::State;
using devices::DriveState;
using test::LoopBench;

struct FallenBench : LoopBench {
  FallenBench() {
    operate();
    enable();
    home();
    EXPECT_EQ(now.enabled, 0b11111u);
  }
  /// As another master would, or the drive's own panel.
  void ask(devices::wire::AlState state) {
    devices::Link link(port, clock);
    const auto asked =
        link.write<std::uint16_t>(z_address(), devices::wire::reg::kAlControl, static_cast<std::uint16_t>(state));
    ASSERT_TRUE(asked) << to_text(asked.error());
  }
  [[nodiscard]] std::uint16_t z_address() const { return master->stations()[4].address; }
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

}  // namespace
}  // namespace gantry
