// Several axes from state to state: each by itself, arriving together, or on a straight line.
//   AxisMove axes[] = {{x0, x1, bounds_x}, {y0, y1, bounds_y}};
//   Joint m = move_together(axes, {.sync = Sync::Phase, .cycle_s = 0.001});      // if (!m) -> m.reason, m.axis
//   State x = evaluate(m.profiles[0], t);
// Pure values, no allocation, bounded iterations: may run in the loop.
#pragma once
#include <span>

#include "core/axis_vec.hpp"
#include "motion/profile/planner.hpp"

namespace gantry::motion {

struct AxisMove {
  State from, to;
  AxisBounds bounds;
  bool enabled = true;  ///< false: not planned, its profile stays empty
};

/// The same for the velocity interface: `to.p` and the bounds on p and v are not used.
enum class Sync : std::uint8_t {
  None,   ///< every axis as soon as it can
  Time,   ///< all arrive together, as soon as the slowest can
  Phase,  ///< on a straight line in p where start, target and speeds lie on one; else as Time
};

struct Together {
  Sync sync = Sync::Time;
  double min_duration_s = 0;
  double cycle_s = 0;  ///< > 0: the duration is a multiple of it
  Outside outside = Outside::Ease;
};

struct Joint {
  Reason reason = Reason::NoSolution;
  std::uint8_t axis = 0;  ///< the one that the reason is about
  double duration_s = 0;  ///< of the longest
  bool straight = false;  ///< phase-synchronised
  rt::FixedVector<Profile, kMaxAxes> profiles;
  explicit operator bool() const noexcept { return reason == Reason::Solved; }
};

/// At most kMaxAxes axes; more are Reason::BadBounds.
Joint move_together(std::span<const AxisMove> axes, const Together& how = {}) noexcept;

/// Velocity interface: to (to.v, to.a), wherever.
Joint change_speeds_together(std::span<const AxisMove> axes, const Together& how = {}) noexcept;

}  // namespace gantry::motion
