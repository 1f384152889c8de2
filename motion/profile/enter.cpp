// Starts outside of the bounds: where they enter them.
#include <algorithm>
#include <cmath>

#include "motion/profile/scale.hpp"

namespace gantry::motion {
namespace {

State negated(const State& x) noexcept { return {-x.p, -x.v, -x.a}; }

/// Too fast (v or what a leads to is over v_max): the shortest time until v <= v_max with nothing left that leads out
/// again. Full jerk down to the strongest deceleration from which the lower bound can still be kept,
/// L^2/(2 j_max) <= v_max - v_min, held until v_max.
void brake_below(const State& x, const AxisBounds& b, double sign, Profile& profile) noexcept {
  const double j = -b.j_min, deepest = std::min(-b.a_min, std::sqrt(2 * b.j_max * (b.v_max - b.v_min)));
  const double over = x.a * x.a + 2 * j * (x.v - b.v_max);  // (deceleration at v_max without a bound on it)^2
  const double at_bound = std::sqrt(std::max(over, 0.0));
  if (at_bound <= deepest) {
    append(profile, (x.a + at_bound) / j, -sign * j);
    return;
  }
  append(profile, std::max(x.a + deepest, 0.0) / j, -sign * j);
  const double low = std::max(deepest, -x.a);  // it may brake harder already
  append(profile, (x.v + (x.a * x.a - low * low) / (2 * j) - b.v_max) / low, 0);
}

AxisBounds mirrored(const AxisBounds& b) noexcept {
  return {-b.v_min, -b.v_max, -b.a_min, -b.a_max, -b.j_min, -b.j_max};
}

}  // namespace

State enter(const State& from, const AxisBounds& b, Outside outside, Profile& profile) noexcept {
  const double coming = coming_speed(from, b), grown = 1 + kSlack;
  const bool fast = std::max(from.v, coming) > b.v_max * grown, slow = std::min(from.v, coming) < b.v_min * grown;
  const bool pushed = from.a > b.a_max * grown || from.a < b.a_min * grown;
  if (!fast && !slow && !pushed) return from;

  if (outside == Outside::Ease && (fast || slow)) {
    const bool up = coming > b.v_max || (coming >= b.v_min && from.v > b.v_max);
    profile.phases = change_speed(from, up ? b.v_max : b.v_min, b).profile.phases;
    return end_state(profile);
  }
  if (pushed) {
    const bool up = from.a > 0;
    append(profile, up ? (from.a - b.a_max) / -b.j_min : (b.a_min - from.a) / b.j_max, up ? b.j_min : b.j_max);
  }
  const State x = end_state(profile);
  const double next = coming_speed(x, b);
  if (std::max(x.v, next) > b.v_max * grown)
    brake_below(x, b, 1, profile);
  else if (std::min(x.v, next) < b.v_min * grown)
    brake_below(negated(x), mirrored(b), -1, profile);
  return end_state(profile);
}

}  // namespace gantry::motion
