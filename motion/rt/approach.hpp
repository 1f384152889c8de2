// Re-planning of s on a straight line: from any state on it to rest at its end, never backwards.
//   Approach p = approach({s, v, a}, length, bounds);   // found: p.profile ends at (length, 0, 0)
// Pure values; safe in the loop.
#pragma once
#include "motion/profile/planner.hpp"

namespace gantry::motion {

struct Approach {
  bool found = false;
  Profile profile;
};

/// A braking distance may be longer than the room for it by this: rounding, far below what any axis resolves.
inline constexpr double kLengthSlack = 1e-11;

/// Fast to the end, at no more than bounds.v (a higher speed now is eased down to it). Not found: the rest of the line
/// is too short for a stop.
Approach approach(const State& x, double length, const Bounds& bounds) noexcept;

/// Distance travelled from x until the speed is v_to without acceleration; for v_to = 0 the braking distance.
double distance_to_speed(const State& x, double v_to, const Bounds& bounds) noexcept;

}  // namespace gantry::motion
