// The planner's face: checks, scaling, starts outside the bounds.
#include "motion/profile/planner.hpp"

#include <algorithm>
#include <cmath>

#include "motion/profile/scaled.hpp"

namespace gantry::motion {
namespace {

// Two states closer than this, relative to the scales of the problem, are one: below what an end state is asked for
// (1e-9), above what positions and bounds carry as doubles.
constexpr double kSame = 1e-12;
// A bound overstepped by less is met.
constexpr double kSlack = 1e-11;

Reason problem_of(const State& x, const Bounds& b) noexcept {
  if (!std::isfinite(x.p) || !std::isfinite(x.v) || !std::isfinite(x.a)) return Reason::NotFinite;
  if (!std::isfinite(b.v) || !std::isfinite(b.a) || !std::isfinite(b.j)) return Reason::NotFinite;
  if (!(b.a > 0) || !(b.j > 0)) return Reason::BadBounds;
  return Reason::Solved;
}

void append(Profile& profile, double duration_s, double jerk) noexcept {
  if (duration_s > 0) profile.phases.push_back({duration_s, jerk});
}

/// Speed that (v, a) comes to when the acceleration is taken out at full jerk.
double coming_speed(const State& x, double j) noexcept { return x.v + x.a * std::abs(x.a) / (2 * j); }

}  // namespace

// With g = |v_to - v| + a^2/(2 j) along the direction of the change, the peak acceleration is sqrt(g j), or a_max held
// for g/a_max - a_max/j.
Plan change_speed(const State& from, double v_to, const Bounds& bounds) noexcept {
  Plan plan;
  plan.profile.from = from;
  plan.reason = problem_of(from, bounds);
  if (plan.reason == Reason::Solved && !std::isfinite(v_to)) plan.reason = Reason::NotFinite;
  if (!plan) return plan;
  const double a_max = bounds.a, j = bounds.j;
  State x = from;
  if (std::abs(x.a) > a_max) {
    const double t = (std::abs(x.a) - a_max) / j;
    append(plan.profile, t, std::copysign(j, -x.a));
    x.v += t * (x.a + std::copysign(a_max, x.a)) / 2;
    x.a = std::copysign(a_max, x.a);
  }
  const double sign = v_to >= coming_speed(x, j) ? 1.0 : -1.0;
  const double a0 = sign * x.a;
  const double g = std::max(sign * (v_to - x.v) + a0 * a0 / (2 * j), 0.0);
  const double peak = std::min(std::sqrt(g * j), a_max);
  append(plan.profile, (peak - a0) / j, sign * j);
  if (g * j > a_max * a_max) append(plan.profile, g / a_max - a_max / j, 0);
  append(plan.profile, peak / j, -sign * j);
  return plan;
}

Plan stop(const State& from, const Bounds& bounds) noexcept { return change_speed(from, 0, bounds); }

Plan move(const State& from, const State& to, const Bounds& bounds) noexcept {
  Plan plan;
  plan.profile.from = from;
  plan.reason = problem_of(from, bounds);
  if (plan && (!std::isfinite(to.p) || !std::isfinite(to.v) || !std::isfinite(to.a))) plan.reason = Reason::NotFinite;
  if (plan && !(bounds.v > 0)) plan.reason = Reason::BadBounds;
  if (!plan) return plan;

  const double a = bounds.a, j = bounds.j, v = bounds.v;
  // A target with acceleration was faster (or will have been slower) a moment before: that too has to be within v.
  const double before = to.v - to.a * std::abs(to.a) / (2 * j);
  if (std::max(std::abs(to.v), std::abs(before)) > v * (1 + kSlack) || std::abs(to.a) > a * (1 + kSlack)) {
    plan.reason = Reason::TargetOutsideBounds;
    return plan;
  }

  const double scale_p = std::max({std::abs(from.p), std::abs(to.p), v * v / a});
  if (std::abs(to.p - from.p) <= kSame * scale_p && std::abs(to.v - from.v) <= kSame * v &&
      std::abs(to.a - from.a) <= kSame * a)
    return plan;

  State x = from;
  const double coming = coming_speed(x, j);
  if (std::abs(x.a) > a * (1 + kSlack) || std::max(std::abs(x.v), std::abs(coming)) > v * (1 + kSlack)) {
    if (std::abs(x.a) > a && std::abs(x.v) <= v && std::abs(coming) <= v) {
      append(plan.profile, (std::abs(x.a) - a) / j, std::copysign(j, -x.a));
    } else {
      plan = change_speed(x, std::copysign(v, std::abs(coming) > v ? coming : x.v), bounds);
    }
    x = end_state(plan.profile);
  }

  const double t = a / j;
  scaled::Problem q;
  q.v0 = std::clamp(x.v, -v, v) / (a * t), q.a0 = std::clamp(x.a / a, -1.0, 1.0);
  q.vf = to.v / (a * t), q.af = std::clamp(to.a / a, -1.0, 1.0);
  q.v_max = v / (a * t);
  q.p = (to.p - x.p) / (a * t * t);
  q.resolution = 1e-13 * scale_p / (a * t * t);
  scaled::Shape shape;
  if (!scaled::shortest(q, shape)) {
    plan.reason = Reason::NoSolution;
    return plan;
  }
  for (int i = 0; i < 7; ++i) append(plan.profile, shape.t[i] * t, shape.sign * scaled::kJerk[i] * j);

  const State end = end_state(plan.profile);
  if (!(std::abs(end.p - to.p) <= 1e-9 * scale_p) || !(std::abs(end.v - to.v) <= 1e-9 * v) ||
      !(std::abs(end.a - to.a) <= 1e-9 * a))
    plan.reason = Reason::NoSolution;
  return plan;
}

}  // namespace gantry::motion
