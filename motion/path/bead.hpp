// A bead: from a polyline of axis vectors to segments with run-up, the fastest speed up to the one that is set, corners
// rounded inside the tolerance, run-out and valve events.
//   auto b = plan_bead(limits, {.points = p, .speed_mm_s = 20, .corner_tolerance_mm = 0.1, ...});
//   line_move(here -> b->start), then b->segments, and the tool rests at b->end
// Start and end of the bead fall on ticks. Off the RT side.
#pragma once
#include <span>
#include <vector>

#include "core/error.hpp"
#include "motion/path/moves.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

struct BeadSpec {
  std::vector<AxisVec> points;  ///< at least two; a closed bead repeats its first point at the end
  double speed_mm_s = 0;  ///< along the path of the linear axes; lower where a corner demands it, never 2e-4 higher
  double corner_tolerance_mm = 0;  ///< how far a corner may be cut; 0: the tool stops in it
  std::uint32_t valve = 0;         ///< output bits that open the valve; 0: a dry bead
  double open_lead_s = 0, close_lead_s = 0;
  /// Its run-up is as long as speeding up to this takes, but for some percent, and it begins about as fast; where the
  /// bead begins with a bend, the run-up comes out of a line into that bend, and is longer by what that takes. 0: from
  /// rest, at its first point.
  double entry_mm_s = kNoCap;
  /// Of one that begins from rest: so long the tool stands there before, and the valve opens when it comes to stand.
  double stand_s = 0;
  /// The run-up begins so much higher on `lift_axis`, and comes down to end with it: a straight one by the shortest
  /// motion of that axis, a bent one by a cubic of its way.
  double fall_mm = 0;
  /// Of a bead that was cut: so much of it lies already, in mm along its motion, and the run-up comes down onto it from
  /// so far above on this axis; from `fall_mm` where that is more, and steeper. With an `entry_mm_s` it goes on as if
  /// it began there, and its run-up is no higher than a tenth of its length.
  double begin_mm = 0, lift_mm = 0;
  double dry_mm = 0;  ///< so far from there the valve opens
  std::size_t lift_axis = 0;
  std::uint32_t block = 0, feature = kTravel;
};

struct BeadMotion {
  AxisVec start{};  ///< where the run-up starts, at rest
  AxisVec end{};    ///< where the run-out ends, at rest
  std::vector<Segment> segments;
  /// Those of the bead itself, between run-up and run-out; first among them the one in which the tool stands. Without a
  /// run-up it begins with the first.
  std::size_t bead_begin = 0, bead_end = 0;
  double bead_length_mm = 0, bead_seconds = 0, run_up_mm = 0, run_out_mm = 0;  ///< of what is left of it
};

/// Fault::NoSolution (fewer than two different points, a speed that is not > 0, rotary motion on the spot, more axes on
/// a curve than a segment carries; nothing is left of it, or no path leads down onto what is; a run-up that is to come
/// down where there is none, or the bead goes down itself),
/// Fault::OutOfReach (a point outside the soft limits), Fault::SpeedNotReachable (run-up or run-out leave the soft
/// limits: the message names the axis and how much room the speed needs).
Result<BeadMotion> plan_bead(const Limits& limits, const BeadSpec& spec);

/// Along these points from rest to rest, without a valve, run-up or run-out, in whole ticks: as fast as the limits and
/// the speed allow, corners rounded inside the tolerance; where no speed is found for that, with a rest in each.
/// Fault::NoSolution (points that are all the same, a speed that is not > 0), Fault::OutOfReach.
Result<std::vector<Segment>> plan_dry(const Limits& limits, std::span<const AxisVec> points, double speed_mm_s,
                                      double tolerance_mm);

}  // namespace gantry::motion
