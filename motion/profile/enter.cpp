// Starts outside of the bounds: where they enter them.
#include <algorithm>
#include <cmath>

#include "motion/profile/scale.hpp"

namespace gantry::motion {
namespace {

State negated(const State& x) noexcept { return {-x.p, -x.v, -x.a}; }

/// Too fast and braking so hard that it comes below v_max anyway: as gently as it may until v_max.
void let_go(const State& x, const AxisBounds& b, double sign, Profile& profile) noexcept {
  const double left = std::sqrt(std::max(x.a * x.a - 2 * b.j_max * (x.v - b.v_max), 0.0));
  append(profile, (-x.a - left) / b.j_max, sign * b.j_max);
}

/// Too fast (v or what a leads to is over v_max): the shortest time until v <= v_max with nothing left that leads out
/// again. Full jerk down to the strongest deceleration from which the lower bound can still be kept,
/// L^2/(2 j_max) <= v_max - v_min, held until v_max. One that brakes harder already lets go in time to have come back
/// to that at v_max, or at once.
void brake_below(const State& x, const AxisBounds& b, double sign, Profile& profile) noexcept {
  const double j = -b.j_min, deepest = std::min(-b.a_min, std::sqrt(2 * b.j_max * (b.v_max - b.v_min)));
  const double over = x.a * x.a + 2 * j * (x.v - b.v_max);  // (deceleration at v_max without a bound on it)^2
  const double at_bound = std::sqrt(std::max(over, 0.0));
  const double back = x.v - b.v_max, hard = -x.a;
  if (hard > deepest) {
    const double lost =
        (hard * hard - deepest * deepest) / (2 * b.j_max);  // of speed, while the acceleration goes to `deepest`
    append(profile, (back - lost) / hard, 0);
    return let_go({x.p, b.v_max + std::min(back, lost), x.a}, b, sign, profile);
  }
  if (at_bound <= deepest) {
    append(profile, (x.a + at_bound) / j, -sign * j);
    return;
  }
  append(profile, (x.a + deepest) / j, -sign * j);
  append(profile, (back + (x.a * x.a - deepest * deepest) / (2 * j)) / deepest, 0);
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
    const bool passes = up ? coming < b.v_max : coming > b.v_min;
    if (!passes) {
      profile.phases = change_speed(from, up ? b.v_max : b.v_min, b).profile.phases;
      return end_state(profile);
    }
    if (!pushed) {
      if (up)
        let_go(from, b, 1, profile);
      else
        let_go(negated(from), mirrored(b), -1, profile);
      return end_state(profile);
    }
  }
  if (pushed) {
    const bool up = from.a > 0;
    append(profile, up ? (from.a - b.a_max) / -b.j_min : (b.a_min - from.a) / b.j_max, up ? b.j_min : b.j_max);
  }
  const auto is_fast = [&](const State& x) { return std::max(x.v, coming_speed(x, b)) > b.v_max * grown; };
  const auto is_slow = [&](const State& x) { return std::min(x.v, coming_speed(x, b)) < b.v_min * grown; };
  State x = end_state(profile);
  const bool first_fast = is_fast(x);
  if (first_fast)
    brake_below(x, b, 1, profile);
  else if (is_slow(x))
    brake_below(negated(x), mirrored(b), -1, profile);
  // One that braked too hard leaves the other bound, as little as it must.
  x = end_state(profile);
  if (first_fast && is_slow(x)) brake_below(negated(x), mirrored(b), -1, profile);
  if (!first_fast && is_fast(x)) brake_below(x, b, 1, profile);
  return end_state(profile);
}

}  // namespace gantry::motion
