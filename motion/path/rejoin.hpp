// A bead that was cut is joined again: what is left of its plan, and a run-up that comes down onto it. The geometry and
// the speeds of what is left are those of the whole bead, so that a joined bead is the one that was planned.
//   std::vector<Run> rest = runs_from(measure, runs, limits, v_set, 31.2);
//   Result<std::vector<Run>> run_up = run_up_from_above(limits, measure, {jet, v0, a0}, {z, 0.6});
//   Result<BeadRuns> both = join_slower(limits, measure, rest, {z, 0.6}, v_set, 8);   // a shorter run-up, or none
// Off the RT side.
#pragma once
#include <vector>

#include "core/error.hpp"
#include "motion/path/lead.hpp"
#include "motion/path/run.hpp"

namespace gantry::motion {

/// What is left of planned runs from `begin_mm` on; empty where nothing is. A straight one that is cut begins as fast
/// as it can.
[[nodiscard]] std::vector<Run> runs_from(const Measure& measure, const std::vector<Run>& runs, const Limits& limits,
                                         double v_set, double begin_mm);

/// Where a run-up ends: place, direction and curvature, speed and acceleration there.
struct Join {
  CurveJet at;
  double v = 0, a = 0;
};

/// Where that state of s is on a path, by true arc length: within a curve |q'| is 1 but for a small error, whose slope
/// a join would else show as a step of acceleration.
[[nodiscard]] Join join_on(const Measure& measure, const CurveJet& at, double v, double a);

/// From rest to the join, in whole ticks; it comes down on the join's tangent, bent as the bead is bent there, and is
/// above the bead until it ends. Fault::NoSolution where no such path is within the limits.
[[nodiscard]] Result<std::vector<Run>> run_up_from_above(const Limits& limits, const Measure& measure, const Join& join,
                                                         const Lift& lift);

/// A run-up, what it leads to, and what leads away, each in runs of its own. The last is empty where it is a line.
struct BeadRuns {
  std::vector<Run> run_up, left, run_out;
};

/// Where the whole run-up has no room: one that is as long as speeding up to `entry_mm_s` takes along the join's
/// tangent, and lower where that is short. The tool goes on speeding up as it joins: it is faster there, as a rule.
/// What is left follows its curves, at v_set at most. 0: no run-up, it begins from rest. Fault::NoSolution where no
/// speed is found.
[[nodiscard]] Result<BeadRuns> join_slower(const Limits& limits, const Measure& measure, const std::vector<Run>& left,
                                           const Lift& lift, double v_set, double entry_mm_s);

}  // namespace gantry::motion
