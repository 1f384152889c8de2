// Where the axes come to rest behind a probe touch: the loop plays it, the forecast of a job counts with it. Safe in
// the loop.
#pragma once
#include "motion/profile/planner.hpp"

namespace gantry::motion {

/// A latch is seen cycles after it happened (the axis' lag, the wire there and back, a host that was late). Braking
/// only this long beyond the latched position, seen early or late, makes every setpoint a function of the position
/// alone.
inline constexpr double kSeenWithin_s = 0.025;

/// `latched` and the result along the line, mm; `bounds.v` is the speed that the course has.
[[nodiscard]] inline double touch_end(double latched, const Bounds& bounds) noexcept {
  return latched + kSeenWithin_s * bounds.v + change_length(bounds.v, 0, bounds.a, bounds.j);
}

}  // namespace gantry::motion
