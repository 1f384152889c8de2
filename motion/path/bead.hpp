// A bead: from a polyline of axis vectors to segments with run-up, constant speed, blended corners, run-out and valve
// events.
//   auto b = plan_bead(limits, {.points = p, .speed_mm_s = 20, .corner_tolerance_mm = 0.1, ...});
//   line_move(here -> b->start), then b->segments, and the tool rests at b->end
// Start and end of the bead fall on ticks. Off the RT side.
#pragma once
#include <vector>

#include "core/error.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

struct BeadSpec {
  std::vector<AxisVec> points;     ///< at least two; a closed bead repeats its first point at the end
  double speed_mm_s = 0;           ///< along the path of the linear axes; lower where a corner demands it
  double corner_tolerance_mm = 0;  ///< how far a corner may be cut; 0: the tool stops in it
  std::uint32_t valve = 0;         ///< output bits that open the valve; 0: a dry bead
  double open_lead_s = 0, close_lead_s = 0;
  std::uint32_t block = 0, feature = kTravel;
};

struct BeadMotion {
  AxisVec start{};  ///< where the run-up starts, at rest
  AxisVec end{};    ///< where the run-out ends, at rest
  std::vector<Segment> segments;
  std::vector<AxisVec> outline;    ///< start, the points, end: the segments follow it, and leave it only at corners ...
  double corner_tolerance_mm = 0;  ///< ... by at most this
  double bead_length_mm = 0, bead_seconds = 0, run_up_mm = 0, run_out_mm = 0;
};

/// Fault::NoSolution (fewer than two different points, a speed that is not > 0, rotary motion on the spot),
/// Fault::OutOfReach (a point outside the soft limits), Fault::SpeedNotReachable (run-up or run-out leave the soft
/// limits: the message names the axis and how much room the speed needs).
Result<BeadMotion> plan_bead(const Limits& limits, const BeadSpec& spec);

}  // namespace gantry::motion
