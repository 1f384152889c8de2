// Segments of the simple motions: a straight line from rest to rest, a line down to the probe's touch, a wait.
//   for (Segment& s : line_move(limits, from, to, v_cap)) { s.block = n; ... push }
// Durations are whole ticks, so that whatever follows starts on one. Off the RT side.
#pragma once
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "motion/types.hpp"

namespace gantry::motion {

inline constexpr double kNoCap = std::numeric_limits<double>::infinity();

/// Length of the displacement of the linear axes, or of the others when no linear axis moves (by more than 1 um).
double path_length(const Limits& limits, const AxisVec& displacement);

/// Straight in all axes, rest to rest, as fast as the axis limits and v_cap (along s) allow. s is the path length of
/// the linear axes, or of the rotary ones where no linear axis moves. Empty where from equals to. Soft limits are the
/// caller's to check: within(limits, q).
std::vector<Segment> line_move(const Limits& limits, const AxisVec& from, const AxisVec& to, double v_cap = kNoCap);

/// A line that ends where the probe latches, and ends its block either way. Empty where from equals to.
std::vector<Segment> probe_move(const Limits& limits, const AxisVec& from, const AxisVec& to, double v_cap);

/// Stands at q for `seconds` (rounded up to whole ticks, at least one); at_s of the events is in seconds.
Segment dwell(const Limits& limits, const AxisVec& q, double seconds, std::span<const OutputEvent> events = {});

/// True when every used axis of q is within its soft limits.
bool within(const Limits& limits, const AxisVec& q);

/// Sum of the nominal durations.
double duration(std::span<const Segment> segments);

}  // namespace gantry::motion
