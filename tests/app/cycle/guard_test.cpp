// Motion that was planned with other limits than the machine's: it is not sent, and what is sent instead keeps them.
#include "app/job/limits.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry::test {
namespace {

/// The largest second difference of an axis over what its limit allows.
double worst_acceleration(const std::vector<AxisVec>& targets, const motion::Limits& limits) {
  double worst = 0;
  for (std::size_t i = 0; i < limits.axes; ++i)
    for (std::size_t n = 2; n < targets.size(); ++n) {
      const double change = targets[n][i] - 2 * targets[n - 1][i] + targets[n - 2][i];
      worst = std::max(worst, std::abs(change) / (limits.tick_s * limits.tick_s * limits.axis[i].a_max));
    }
  return worst;
}

TEST(Guard, stops_an_axis_within_its_limits_where_a_plan_would_break_them) {
  LoopBench b;
  b.operate();
  b.enable();
  b.home();
  if (HasFatalFailure()) return;
  const motion::Limits limits = job::limits_of(b.machine);
  motion::Limits wrong = limits;
  wrong.axis[0].a_max *= 4, wrong.axis[0].j_max *= 2;
  const AxisVec from = b.now.target;
  AxisVec to = from;
  to[0] += from[0] > 0.5 * (limits.axis[0].p_min + limits.axis[0].p_max) ? -200 : 200;
  to[1] += from[1] > 0.5 * (limits.axis[1].p_min + limits.axis[1].p_max) ? -5 : 5;
  std::vector<motion::Segment> segments = motion::line_move(wrong, from, to);
  b.play(segments);
  std::vector<AxisVec> targets;
  for (int i = 0; i < 1500; ++i) {
    b.tick();
    targets.push_back(b.now.target);
  }
  EXPECT_EQ(b.now.latched, Fault::TargetStep);
  EXPECT_EQ(b.told(Fault::TargetStep), 1);
  EXPECT_EQ(b.now.state, cycle::State::Stopped);
  EXPECT_LE(worst_acceleration(targets, limits), 1.001 + 1e-3);
  EXPECT_GT(std::abs(targets.back()[0] - from[0]), 0.1) << "it moved before it was stopped";
  EXPECT_GT(std::abs(targets.back()[0] - to[0]), 100);
  EXPECT_EQ(targets.back(), targets[targets.size() - 100]) << "it stands";
  EXPECT_EQ(b.told(Fault::FollowingError), 0);
}

}  // namespace
}  // namespace gantry::test
