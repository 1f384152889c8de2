// Hardest braking of a state on its way to a position limit: how far it still goes.
//   Brake b = brake_up(x, bounds);        // b.top <= p_max: the upper limit can be kept
#pragma once
#include <algorithm>
#include <cmath>

#include "motion/profile/planner.hpp"

namespace gantry::motion {

struct Brake {
  double top = 0;      ///< farthest position on that side (down: negated)
  double at_top = 0;   ///< deceleration there, >= 0
  bool rises = false;  ///< else it is farthest now
};

/// Jerk -j down to -a_down, until the speed is 0.
[[nodiscard]] inline Brake brake(double p, double v, double a, double a_down, double j) noexcept {
  const double disc = a * a + 2 * j * v;
  if ((v <= 0 && a <= 0) || disc < 0) return {p, 0, false};
  const double root = std::sqrt(disc), t = (a + root) / j;
  if (root <= a_down) return {std::max(p, p + t * (v + t * (a / 2 - t * j / 6))), root, true};
  const double t1 = std::max(a + a_down, 0.0) / j, v1 = v + t1 * (a - t1 * j / 2);
  return {std::max(p, p + t1 * (v + t1 * (a / 2 - t1 * j / 6)) + v1 * v1 / (2 * a_down)), a_down, true};
}

[[nodiscard]] inline Brake brake_up(const State& x, const AxisBounds& b) noexcept {
  return brake(x.p, x.v, x.a, -b.a_min, -b.j_min);
}
[[nodiscard]] inline Brake brake_down(const State& x, const AxisBounds& b) noexcept {
  return brake(-x.p, -x.v, -x.a, b.a_max, b.j_max);
}
/// Where the state came from, braked in reversed time: speed and jerk change their signs.
[[nodiscard]] inline Brake came_up(const State& x, const AxisBounds& b) noexcept {
  return brake(x.p, -x.v, x.a, -b.a_min, b.j_max);
}
[[nodiscard]] inline Brake came_down(const State& x, const AxisBounds& b) noexcept {
  return brake(-x.p, x.v, -x.a, b.a_max, -b.j_min);
}

}  // namespace gantry::motion
