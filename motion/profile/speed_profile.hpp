// s(t) of a segment. Safe in the loop.
//   double t = duration(segment.nominal);   State x = along(segment.nominal, t / 2).x;
#pragma once
#include <algorithm>

#include "motion/types.hpp"

namespace gantry::motion {

[[nodiscard]] inline double duration(const SpeedProfile& profile) noexcept {
  double sum = 0;
  for (const Phase& phase : profile.phases) sum += phase.duration_s;
  return sum;
}

/// State and jerk at a time; before the start it is that of the start, beyond the end that of the end.
struct Along {
  State x;
  double jerk = 0;
};
[[nodiscard]] inline Along along(const SpeedProfile& profile, double t) noexcept {
  Along out{{0, profile.v0, profile.a0}, 0};
  State& x = out.x;
  for (const Phase& phase : profile.phases) {
    const double dt = std::min(t, phase.duration_s), j = out.jerk = phase.jerk;
    if (dt > 0) x = advanced(x, j, dt);
    t -= phase.duration_s;
    if (t < 0) break;
  }
  return out;
}

/// When s is first come to; s within what the profile covers.
[[nodiscard]] inline double time_at(const SpeedProfile& profile, double s) noexcept {
  double low = 0, high = duration(profile);
  for (int n = 0; n < 60; ++n) {
    const double middle = (low + high) / 2;
    (along(profile, middle).x.p < s ? low : high) = middle;
  }
  return high;
}

}  // namespace gantry::motion
