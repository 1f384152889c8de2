// A planned path as runs: a curve, or a part of it, with the speed that belongs to it. What turns a plan into segments.
//   std::vector<Run> runs = runs_between(measure, stretch, s0, s1);  speed_up_lines(runs, limits, v);  slow_down(runs,
//   factor); for (const Run& r : runs) append_segments(r, like, segments);
// Off the RT side.
#pragma once
#include <span>
#include <vector>

#include "motion/path/moves.hpp"
#include "motion/path/timing.hpp"
#include "motion/profile/planner.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

struct Run {
  Curve curve;
  double v0 = 0, a0 = 0;      ///< at its start
  std::vector<Phase> phases;  ///< they end at the curve's end
  double v1 = 0, a1 = 0;      ///< there
  double begin = 0;           ///< mm of the curve that are left out before it
};

[[nodiscard]] double duration(std::span<const Run> runs);

/// One run for each curve of the stretch that lies between these lengths, where curves begin and end; straight curves
/// that go on without a rest are one.
[[nodiscard]] std::vector<Run> runs_between(const Measure& measure, const Stretch& stretch, double from_mm,
                                            double to_mm);

/// The same of what leads to or away from a path; empty where all of it is one line.
[[nodiscard]] std::vector<Run> bent_runs(const Measure& measure, const Stretch& stretch, double from_mm, double to_mm);

/// Straight runs take the shortest time between the speeds at their ends, within the axis limits and v_set; where one
/// is the first or the last of `runs`, it starts or ends at v_set without acceleration, if it can; it starts at
/// `entry_mm_s` at most.
void speed_up_lines(std::vector<Run>& runs, const Limits& limits, double v_set, double entry_mm_s = kNoCap);

/// The same in factor times the time: speeds / factor, accelerations / factor^2, jerks / factor^3.
void slow_down(std::span<Run> runs, double factor);

/// A straight run from `from` along `direction` (q') with this motion, which gives its length.
[[nodiscard]] Run straight_run(const Measure& measure, const AxisVec& from, const AxisVec& direction, bool backwards,
                               const Profile& motion);

/// How many axes move.
[[nodiscard]] std::size_t moving_axes(const Curve& curve);

/// As segments of kind Piece that are otherwise like `like`; the last one rests if the curve does.
void append_segments(const Run& run, const Segment& like, std::vector<Segment>& out);

}  // namespace gantry::motion
