// What holds in the loop while an axis walks, whatever was planned.
#include "app/job/limits.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry::test {
namespace {

using cycle::CommandKind;
using cycle::Purpose;

struct Walking : LoopBench {
  explicit Walking(bool in_setup) {
    operate();
    std::uint16_t levels = 0;
    for (const auto input : {config::Input::Stop, config::Input::DoorClosed, config::Input::AirOk,
                             config::Input::SafetyOk, config::Input::Mode, config::Input::ClampClosed})
      if (!in_setup || input != config::Input::Mode)
        levels = static_cast<std::uint16_t>(levels | 1u << machine.inputs[static_cast<std::size_t>(input)]->bit);
    segment.set_io_inputs(io, levels);
    ticks(20);
    enable();
    start = now.actual[0];
  }
  Fault walk(double by, Purpose purpose) {
    motion::Limits limits = job::limits_of(machine);
    limits.axis[0].p_min = -1e6, limits.axis[0].p_max = 1e6;
    AxisVec to = now.target;
    to[0] += by;
    for (motion::Segment& s : segments = motion::line_move(limits, now.target, to, 2)) {
      s.block = 1;
      s.ends_block = &s == &segments.back();
      EXPECT_TRUE(channels->segments.push(s));
    }
    return command({.kind = CommandKind::StartBlock, .block = 1, .purpose = purpose});
  }
  double start = 0;
  std::vector<motion::Segment> segments;
};

TEST(WalkBound, no_axis_goes_farther_than_a_walk_may) {
  for (const double by : {5.0, -5.0}) {
    Walking b(true);
    if (HasFatalFailure()) return;
    EXPECT_EQ(b.now.referenced, 0u);
    ASSERT_EQ(b.walk(by, Purpose::Walk), Fault::None);
    b.ticks(3000);
    EXPECT_EQ(b.now.latched, Fault::SoftLimit) << by;
    EXPECT_NEAR(b.now.actual[0] - b.start, by > 0 ? 1 : -1, 0.01) << by;
  }
}

TEST(WalkBound, it_may_be_where_a_soft_limit_of_a_place_that_nobody_knows_would_be) {
  Walking b(true);
  if (HasFatalFailure()) return;
  ASSERT_EQ(b.walk(0.9, Purpose::Walk), Fault::None);
  b.ticks(1500);
  EXPECT_EQ(b.now.latched, Fault::None);
  EXPECT_NEAR(b.now.actual[0] - b.start, 0.9, 0.01);
}

TEST(WalkBound, plays_in_setup_only_and_what_is_no_walk_or_jog_does_not_play_there) {
  Walking automatic(false);
  if (HasFatalFailure()) return;
  EXPECT_EQ(automatic.walk(0.5, Purpose::Walk), Fault::Refused);
  EXPECT_EQ(automatic.walk(0.5, Purpose::Job), Fault::NotReferenced);
  Walking setup(true);
  if (HasFatalFailure()) return;
  EXPECT_EQ(setup.walk(0.5, Purpose::Job), Fault::SetupMode);
  EXPECT_EQ(setup.walk(0.5, Purpose::Jog), Fault::SetupMode);
  EXPECT_EQ(setup.walk(0.5, Purpose::SlowJog), Fault::NotReferenced);
  EXPECT_NEAR(setup.now.actual[0], setup.start, 0.002);
}

}  // namespace
}  // namespace gantry::test
