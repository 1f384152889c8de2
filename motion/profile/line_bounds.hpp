// What the axis limits leave of s on a straight line. Safe in the loop.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/change_duration.hpp"
#include "motion/profile/planner.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

/// Bounds of s with q' = direction.
[[nodiscard]] inline Bounds line_bounds(const Limits& limits, const AxisVec& direction) noexcept {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Bounds b{kNone, kNone, kNone};
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const double d = std::abs(direction[i]);
    if (d < 1e-12) continue;
    b.v = std::min(b.v, limits.axis[i].v_max / d);
    b.a = std::min(b.a, limits.axis[i].a_max / d);
    b.j = std::min(b.j, limits.axis[i].j_max / d);
  }
  return b;
}

/// Of a stop of the slowest axis that makes path length, on a line, from v_mm_s of the tool or the axis' own speed.
[[nodiscard]] inline double longest_stop_s(const Limits& limits, double v_mm_s) noexcept {
  double longest = 0;
  for (std::size_t i = 0; i < limits.axes; ++i)
    if (const AxisLimits& l = limits.axis[i]; limits.linear[i])
      longest = std::max(longest, change_duration(std::min(v_mm_s, l.v_max), l.a_max, l.j_max));
  return longest;
}

}  // namespace gantry::motion
