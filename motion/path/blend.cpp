#include "motion/path/blend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gantry::motion {

double blend_reach(const Limits& limits, const AxisVec& d1, const AxisVec& d2, double tolerance_mm) {
  double turn = 0;
  for (std::size_t i = 0; i < limits.axes; ++i)
    if (limits.linear[i]) turn += (d2[i] - d1[i]) * (d2[i] - d1[i]);
  turn = std::sqrt(turn);
  if (turn < 1e-12) return std::numeric_limits<double>::infinity();
  return tolerance_mm / (3.0 / 16 * turn);
}

// q(u) = q(0) + l [d1 u + (d2 - d1)(u^3 - u^4/2)],  l = 2 d;  q(1) = q(0) + l (d1 + d2)/2 = corner + d d2.
Geometry blend(const AxisVec& corner, const AxisVec& d1, const AxisVec& d2, double d) {
  Geometry g;
  g.length = 2 * d;
  g.degree = 4;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    g.c[0][i] = corner[i] - d * d1[i];
    g.c[1][i] = g.length * d1[i];
    g.c[3][i] = g.length * (d2[i] - d1[i]);
    g.c[4][i] = -g.length * (d2[i] - d1[i]) / 2;
  }
  return g;
}

// |q''| <= 3/2 |d2 - d1| / l and |q'''| <= 6 |d2 - d1| / l^2. An axis has
//   q' v <= V,   q'' v^2 + q' a <= A,   q''' v^3 + 3 q'' v a + q' j <= J.
// v takes at most half of A and half of J, a what is left of A but in the mixed term at most a quarter of J, j the
// rest.
Bounds blend_bounds(const Limits& limits, const AxisVec& d1, const AxisVec& d2, double d, double v_wanted) {
  constexpr double kTopOverride = 2;  // more than that is never asked for
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const double l = 2 * d;
  Bounds b{kTopOverride * v_wanted, kNone, kNone};
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const auto& [p_min, p_max, v_max, a_max, j_max] = limits.axis[i];
    const double q1 = std::max(std::abs(d1[i]), std::abs(d2[i])), turn = std::abs(d2[i] - d1[i]);
    if (q1 > 1e-12) b.v = std::min(b.v, v_max / q1);
    if (turn > 1e-12) {
      b.v = std::min(b.v, std::sqrt(a_max / 2 / (1.5 * turn / l)));
      b.v = std::min(b.v, std::cbrt(j_max / 2 / (6 * turn / (l * l))));
    }
  }
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const double q1 = std::max(std::abs(d1[i]), std::abs(d2[i])), q2 = 1.5 * std::abs(d2[i] - d1[i]) / l;
    if (q1 > 1e-12) b.a = std::min(b.a, (limits.axis[i].a_max - q2 * b.v * b.v) / q1);
    if (q2 > 0) b.a = std::min(b.a, limits.axis[i].j_max / 4 / (3 * q2 * b.v));
  }
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const double q1 = std::max(std::abs(d1[i]), std::abs(d2[i])), turn = std::abs(d2[i] - d1[i]);
    const double spent = 6 * turn / (l * l) * b.v * b.v * b.v + 4.5 * turn / l * b.v * b.a;
    if (q1 > 1e-12) b.j = std::min(b.j, (limits.axis[i].j_max - spent) / q1);
  }
  return b;
}

}  // namespace gantry::motion
