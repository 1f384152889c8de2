// Evaluation of constant-jerk profiles and the closed forms around a change of speed.
#include <algorithm>
#include <cmath>

#include "core/change_duration.hpp"
#include "motion/profile/planner.hpp"

namespace gantry::motion {
const char* name(Reason reason) noexcept {
  switch (reason) {
    case Reason::Solved: return "solved";
    case Reason::NotFinite: return "not finite";
    case Reason::BadBounds: return "bad bounds";
    case Reason::TargetOutsideBounds: return "target outside bounds";
    case Reason::StartCannotStay: return "start cannot stay";
    case Reason::NoMotionWithin: return "no motion within";
    case Reason::NoSolution: return "no solution";
  }
  return "unknown";
}

double duration(const Profile& profile) noexcept {
  double sum = 0;
  for (const Phase& phase : profile.phases) sum += phase.duration_s;
  return sum;
}

State evaluate(const Profile& profile, double t) noexcept {
  State x = profile.from;
  for (const Phase& phase : profile.phases) {
    const double step = std::min(t, phase.duration_s);
    x = advanced(x, phase.jerk, step);
    t -= step;
    if (t <= 0) return x;
  }
  return advanced(x, 0, t);
}

State end_state(const Profile& profile) noexcept {
  State x = profile.from;
  for (const Phase& phase : profile.phases) x = advanced(x, phase.jerk, phase.duration_s);
  return x;
}

Extent extent(const Profile& profile) noexcept {
  State x = profile.from;
  Extent out{x.p, x.p};
  const auto meet = [&out](double p) { out.low = std::min(out.low, p), out.high = std::max(out.high, p); };
  for (const Phase& phase : profile.phases) {
    // v(t) = 0 inside: a root of v + a t + j t^2/2.
    const double disc = x.a * x.a - 2 * phase.jerk * x.v;
    if (disc >= 0) {
      const double q = -(x.a + std::copysign(std::sqrt(disc), x.a));
      for (const double t : {q / phase.jerk, q != 0 ? 2 * x.v / q : 0})
        if (t > 0 && t < phase.duration_s) meet(advanced(x, phase.jerk, t).p);
    }
    x = advanced(x, phase.jerk, phase.duration_s);
    meet(x.p);
  }
  return out;
}

Profile stretched(const Profile& profile, double factor) noexcept {
  Profile out = profile;
  out.from.v /= factor;
  out.from.a /= factor * factor;
  for (Phase& phase : out.phases) {
    phase.duration_s *= factor;
    phase.jerk /= factor * factor * factor;
  }
  return out;
}

// A change of speed is symmetric about its middle: its length is the mean speed times its duration.
double change_length(double v, double v_to, double a, double j) noexcept {
  return (v + v_to) / 2 * change_duration(std::abs(v_to - v), a, j);
}

// Inverse of change_length in the higher speed v + d.
//   d <= a^2/j: with z = sqrt(d/j):  j z^3 + 2 v z = length, convex and rising: Newton from above never oversteps.
//   else:       d^2/a + d (2v/a + a/j) + 2 v a/j - 2 length = 0.
double speed_over_length(double v, double length, const Bounds& bounds) noexcept {
  if (length <= 0 || v >= bounds.v) return v;
  const double a = bounds.a, j = bounds.j;
  const double knee = a * a / j;
  double d = 0;
  if (length <= (2 * v + knee) * a / j) {
    double z = std::cbrt(length / j);
    if (2 * v * z > length) z = length / (2 * v);
    for (int i = 0; i < 30; ++i) {
      const double step = (z * (j * z * z + 2 * v) - length) / (3 * j * z * z + 2 * v);
      z -= step;
      if (!(step > 1e-15 * z)) break;
    }
    d = j * z * z;
  } else {
    const double half = v + knee / 2;  // (2 v/a + a/j) a / 2
    const double rest = a * (2 * length - 2 * v * a / j);
    d = rest / (half + std::sqrt(half * half + rest));
  }
  return std::min(v + d, bounds.v);
}

}  // namespace gantry::motion
