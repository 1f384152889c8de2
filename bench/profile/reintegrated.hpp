// What a profile really does: integrated again in long double, apart from the planner.
#pragma once
#include <algorithm>
#include <cmath>

#include "motion/profile/planner.hpp"

namespace gantry::bench {

struct Excess {
  double end = 0;    ///< of the end state: p of max(|p0|, |pf|, v^2/a), v and a of their bounds
  double limit = 0;  ///< by which v, a or jerk exceed their bounds, of these; 0: they do not
};

/// `position`: pf counts. Starts outside of the bounds are not held against the profile: what is met before the start's
/// own excess is over is measured by it.
inline Excess reintegrate(const motion::Profile& profile, const motion::State& to, const motion::AxisBounds& b,
                          bool position, bool speed_bounds) {
  using Long = long double;
  Long p = profile.from.p, v = profile.from.v, a = profile.from.a, excess = 0;
  const auto over = [](Long x, Long high, Long low) { return std::max({(x - high) / high, (low - x) / -low, 0.0L}); };
  Long v_before = over(v, b.v_max, b.v_min), a_before = over(a, b.a_max, b.a_min);
  // An acceleration at the start that leads out of the speed bound does so however the jerk is chosen.
  const Long unavoidable = v + a * std::abs(a) / (2 * (a > 0 ? -b.j_min : b.j_max));
  v_before = std::max(v_before, over(unavoidable, b.v_max, b.v_min));
  const auto meet = [&] {
    if (speed_bounds) excess = std::max(excess, over(v, b.v_max, b.v_min) - v_before);
    excess = std::max(excess, over(a, b.a_max, b.a_min) - a_before);
  };
  for (const motion::Phase& phase : profile.phases) {
    const Long t = phase.duration_s, j = phase.jerk;
    excess = std::max(excess, over(j, b.j_max, b.j_min));
    if (j != 0 && -a / j > 0 && -a / j < t) {
      const Long turn = -a / j, at = v + a * turn / 2;
      if (speed_bounds) excess = std::max(excess, over(at, b.v_max, b.v_min) - v_before);
    }
    p += t * (v + t * (a / 2 + t * j / 6));
    v += t * (a + t * j / 2);
    a += t * j;
    meet();
  }
  const Long v_bound =
      speed_bounds ? std::max(b.v_max, -b.v_min) : std::max({std::abs(to.v), std::abs(profile.from.v), 1e-300});
  const Long a_bound = std::max(b.a_max, -b.a_min);
  const Long scale = std::max({(Long)std::abs(profile.from.p), (Long)std::abs(to.p), v_bound * v_bound / a_bound});
  Long end = std::max(std::abs(v - to.v) / v_bound, std::abs(a - to.a) / a_bound);
  if (position) end = std::max(end, std::abs(p - to.p) / scale);
  return {static_cast<double>(end), static_cast<double>(std::max(excess, 0.0L))};
}

/// By how much a profile leaves the position limits, of max(|p0|, |pf|, v^2/a).
inline double outside(const motion::Profile& profile, const motion::State& to, const motion::AxisBounds& b) {
  using Long = long double;
  Long p = profile.from.p, v = profile.from.v, a = profile.from.a, out = std::max({b.p_min - p, p - b.p_max, 0.0L});
  for (const motion::Phase& phase : profile.phases) {
    const Long t = phase.duration_s, j = phase.jerk;
    const auto meet = [&](Long u) {
      if (!(u > 0 && u <= t)) return;
      const Long at = p + u * (v + u * (a / 2 + u * j / 6));
      out = std::max({out, b.p_min - at, at - b.p_max});
    };
    // The speed's zeros: v + a u + j u^2 / 2 = 0.
    const Long disc = a * a - 2 * j * v;
    if (j == 0)
      meet(-v / a);
    else if (disc >= 0)
      meet((-a + std::sqrt(disc)) / j), meet((-a - std::sqrt(disc)) / j);
    meet(t);
    p += t * (v + t * (a / 2 + t * j / 6));
    v += t * (a + t * j / 2);
    a += t * j;
  }
  const Long v_most = std::max(b.v_max, -b.v_min), a_most = std::max(b.a_max, -b.a_min);
  return static_cast<double>(
      out / std::max({(Long)std::abs(profile.from.p), (Long)std::abs(to.p), v_most * v_most / a_most}));
}

}  // namespace gantry::bench
