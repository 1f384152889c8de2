// Re-planning of s within one segment: from any state on it to its end, never backwards, with acceleration 0 there.
//   Approach p = approach({s, v, a}, length, v_allowed, v_now, bounds);   // found: p.profile ends at (length, p.v_out,
//   0)
// Pure values; safe in the loop.
#pragma once
#include <limits>

#include "motion/profile/planner.hpp"

namespace gantry::motion {

struct Approach {
  bool found = false;
  Profile profile;
  double v_out = 0;
};

/// What a way may be longer than the room for it: rounding, far below what any axis resolves.
inline constexpr double kWaySlack = 1e-11;

/// v_now where no course is given up: the acceleration is 0, and x was come to safely.
inline constexpr double kNoCourse = std::numeric_limits<double>::infinity();

/// Fast to the end of a segment, at no more than bounds.v on the way (a higher speed now is eased down to it) and no
/// more than v_allowed at the end. Where the rest of the segment is too short for v_allowed, v_out is the nearest speed
/// that can be had, but not above v_now, the speed that the course which is given up would have had there. Not found:
/// keep that course until the end.
Approach approach(const State& x, double length, double v_allowed, double v_now, const Bounds& bounds) noexcept;

/// From the beginning of a segment, where no course is given up.
inline Approach approach(double v_in, double length, double v_allowed, const Bounds& bounds) noexcept {
  return approach({0, v_in, 0}, length, v_allowed, kNoCourse, bounds);
}

/// Way from x until the speed is v_to without acceleration.
double way_to_speed(const State& x, double v_to, const Bounds& bounds) noexcept;

}  // namespace gantry::motion
