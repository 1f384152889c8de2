// The planner's inner problem without units: time in a/j, so that acceleration and jerk bounds are 1. With T = a/j:
// v* = v / (a T), p* = p / (a T^2). Tolerances below are relative to these.
#pragma once
#include "motion/profile/planner.hpp"

namespace gantry::motion::scaled {

struct Problem {
  double v0 = 0, a0 = 0;  ///< |a0| <= 1
  double vf = 0, af = 0;  ///< |af| <= 1
  double v_max = 0;
  double p = 0;           ///< way from start to target
  double resolution = 0;  ///< what p is uncertain by: rounding of the positions it came from
};

/// Durations of the phases with jerk sign * (+1, 0, -1, 0, -1, 0, +1). The fourth coasts at the speed bound; without it
/// third and fifth are one.
struct Shape {
  double t[7] = {};
  double sign = 1;
  [[nodiscard]] double duration() const noexcept { return t[0] + t[1] + t[2] + t[3] + t[4] + t[5] + t[6]; }
};
inline constexpr double kJerk[7] = {1, 0, -1, 0, -1, 0, 1};

/// False: numerically out of range.
bool shortest(const Problem& problem, Shape& best) noexcept;

}  // namespace gantry::motion::scaled
