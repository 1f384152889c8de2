// q(s) of a segment and its derivatives by s: what the loop, the planner and every judge evaluate alike.
//   AxisVec q = point(segment.geometry, s);   q' = derivative<1>(segment.geometry, s)
// s is clamped to nothing: callers stay within [0, length]. Safe in the loop.
#pragma once
#include "motion/types.hpp"

namespace gantry::motion {

/// n-th derivative of q by s at s (n = 0: the point). A standstill (degree 0, or no length) has none.
template <int n>
[[nodiscard]] inline AxisVec derivative(const Geometry& g, double s) noexcept {
  AxisVec out{};
  if (g.degree == 0 || g.length <= 0) {
    if constexpr (n == 0) out = g.c[0];
    return out;
  }
  const double u = s / g.length;
  for (int k = g.degree; k >= n; --k) {
    double factor = 1;
    for (int m = 0; m < n; ++m) factor *= static_cast<double>(k - m) / g.length;
    const AxisVec& c = g.c[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < kMaxAxes; ++i) out[i] = out[i] * u + factor * c[i];
  }
  return out;
}

[[nodiscard]] inline AxisVec point(const Geometry& g, double s) noexcept { return derivative<0>(g, s); }

}  // namespace gantry::motion
