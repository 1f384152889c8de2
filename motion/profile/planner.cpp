// The planner's face for one axis: checks, a start outside of the bounds, the shortest motion from there.
#include "motion/profile/planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/profile/reachable.hpp"
#include "motion/profile/scale.hpp"

namespace gantry::motion {
// Along the direction of the change (jerk +j_up, 0, -j_down): with g = (v_to - v) + a^2/(2 j_up) + a_to^2/(2 j_down)
// and c = (1/j_up + 1/j_down)/2 the peak P is sqrt(g/c), or a_max held for (g - c a_max^2)/a_max.
Plan change_speed(const State& from, double v_to, const AxisBounds& bounds, double a_to) noexcept {
  Plan plan;
  plan.profile.from = from;
  plan.reason = problem_of(from, bounds);
  if (plan && (!std::isfinite(v_to) || !std::isfinite(a_to))) plan.reason = Reason::NotFinite;
  if (plan && (a_to > bounds.a_max * (1 + kSlack) || a_to < bounds.a_min * (1 + kSlack)))
    plan.reason = Reason::TargetOutsideBounds;
  if (!plan) return plan;
  State x = from;
  if (x.a > bounds.a_max || x.a < bounds.a_min) {
    const double bound = x.a > 0 ? bounds.a_max : bounds.a_min, jerk = x.a > 0 ? bounds.j_min : bounds.j_max;
    const double t = (bound - x.a) / jerk;
    append(plan.profile, t, jerk);
    x.v += t * (x.a + bound) / 2;
    x.a = bound;
  }
  // One ramp from a to a_to comes to this speed.
  const double ramp_jerk = a_to >= x.a ? bounds.j_max : bounds.j_min;
  const double beyond = (v_to - x.v) - (a_to - x.a) * (a_to + x.a) / (2 * ramp_jerk);
  const double unsure = 8 * std::numeric_limits<double>::epsilon() *
                        (std::abs(v_to) + std::abs(x.v) + (a_to * a_to + x.a * x.a) / (2 * std::abs(ramp_jerk)));
  if (std::abs(beyond) <= unsure) {  // that ramp alone: rounding must not ask for a detour
    append(plan.profile, (a_to - x.a) / ramp_jerk, ramp_jerk);
    return plan;
  }
  const bool up = beyond > 0;
  const double sign = up ? 1 : -1, a_max = up ? bounds.a_max : -bounds.a_min;
  const double j_up = up ? bounds.j_max : -bounds.j_min, j_down = up ? -bounds.j_min : bounds.j_max;
  const double a0 = sign * x.a, af = sign * a_to, c = (1 / j_up + 1 / j_down) / 2;
  const double g = std::max(sign * (v_to - x.v) + a0 * a0 / (2 * j_up) + af * af / (2 * j_down), 0.0);
  const double peak = std::max({std::min(std::sqrt(g / c), a_max), a0, af});
  append(plan.profile, (peak - a0) / j_up, sign * j_up);
  if (peak >= a_max) append(plan.profile, (g - c * a_max * a_max) / a_max, 0);
  append(plan.profile, (peak - af) / j_down, -sign * j_down);
  return plan;
}

Plan stop(const State& from, const AxisBounds& bounds) noexcept { return change_speed(from, 0, bounds); }

Reason append_shortest(const State& from, const State& to, const AxisBounds& bounds, Profile& profile,
                       double resolution) noexcept {
  const Scale scale(bounds);
  scaled::Reachable reachable(scale.ends(from, to), scale.box);
  const scaled::Found found = reachable.first((to.p - from.p) / scale.p, resolution / scale.p);
  if (found.side == scaled::Side::None || !std::isfinite(found.duration)) return Reason::NoSolution;
  append(profile, reachable.shape(found), scale);
  return Reason::Solved;
}

Plan move(const State& from, const State& to, const AxisBounds& bounds, Outside outside) noexcept {
  Plan plan;
  plan.profile.from = from;
  plan.reason = problem_of(from, bounds);
  if (plan) plan.reason = problem_of_target(to, bounds);
  if (plan && (from.p < bounds.p_min || from.p > bounds.p_max)) plan.reason = Reason::StartCannotStay;
  if (!plan) return plan;

  const double scale_p = position_scale(from, to, bounds);
  const State inside = enter(from, bounds, outside, plan.profile);
  const bool was_outside = !plan.profile.phases.empty();
  if (const auto ramp = one_ramp(plan.profile, inside, to, bounds)) {
    append(plan.profile, ramp->duration_s, ramp->jerk);
    return plan;
  }
  const bool walls = std::isfinite(bounds.p_min) || std::isfinite(bounds.p_max);
  plan.reason =
      (walls ? append_between_walls : append_shortest)(inside, to, bounds, plan.profile, kResolution * scale_p);
  if (plan && !arrives(plan.profile, to, bounds, scale_p, was_outside)) plan.reason = Reason::NoSolution;
  return plan;
}

}  // namespace gantry::motion
