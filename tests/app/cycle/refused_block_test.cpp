// A block that the loop does not let begin leaves nothing behind.
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

TEST(RefusedBlock, is_not_played_by_the_next_one_of_its_number) {
  test::LoopBench b;
  b.operate();
  AxisVec elsewhere{};
  elsewhere[b.machine.x.value] = 300;
  AxisVec farther = elsewhere;
  farther[b.machine.x.value] = 310;
  for (motion::Segment s : motion::line_move(b.setup.limits, elsewhere, farther)) {
    s.block = 1;
    s.ends_block = true;
    ASSERT_TRUE(b.channels->segments.push(s));
  }
  ASSERT_EQ(b.command({.kind = cycle::CommandKind::StartBlock, .block = 1}), Fault::Refused) << "without torque";
  b.enable();
  b.home();
  b.ticks(10);
  AxisVec to = b.now.target;
  to[b.machine.x.value] += 5;
  b.play(motion::line_move(b.setup.limits, b.now.target, to));
  ASSERT_TRUE(b.until([&] { return b.now.state == cycle::State::Ready; }, 1000));
  EXPECT_EQ(b.now.latched, Fault::None);
  EXPECT_NEAR(b.now.target[b.machine.x.value], to[b.machine.x.value], 1e-9);
}

}  // namespace
}  // namespace gantry
