// A block whose motion comes too late: the tool waits on its path, says so once (R63), and goes on when there is more.
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

TEST(Starved, a_block_that_waits_for_its_motion_is_noted_once_and_goes_on) {
  test::LoopBench b;
  b.operate();
  b.enable();
  b.home();
  const std::size_t x = b.machine.x.value;
  AxisVec half = b.now.target;
  half[x] += 5;
  AxisVec to = half;
  to[x] += 5;
  const auto push = [&](std::vector<motion::Segment> segments, bool ends) {
    for (motion::Segment& s : segments) {
      s.block = 1;
      s.ends_block = ends && &s == &segments.back();
      ASSERT_TRUE(b.channels->segments.push(s));
    }
  };
  push(motion::line_move(b.setup.limits, b.now.target, half), false);
  ASSERT_EQ(b.command({.kind = cycle::CommandKind::StartBlock, .block = 1}), Fault::None);
  b.ticks(500);
  EXPECT_EQ(b.now.state, cycle::State::Running);
  EXPECT_NEAR(b.now.target[x], half[x], 1e-9);
  EXPECT_EQ(b.told(Fault::Starved), 1);
  push(motion::line_move(b.setup.limits, half, to), true);
  ASSERT_TRUE(b.until([&] { return b.now.state == cycle::State::Ready; }, 1000));
  EXPECT_NEAR(b.now.target[x], to[x], 1e-9);
  EXPECT_EQ(b.told(Fault::Starved), 1);
  EXPECT_EQ(b.now.latched, Fault::None);
}

}  // namespace
}  // namespace gantry
