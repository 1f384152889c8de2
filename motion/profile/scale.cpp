#include "motion/profile/scale.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {

Scale::Scale(const AxisBounds& b) noexcept {
  a = std::max(b.a_max, -b.a_min), j = std::max(b.j_max, -b.j_min);
  t = a / j, v = a * t, p = v * t;
  box = {b.v_max / v, -b.v_min / v, b.a_max / a, -b.a_min / a, b.j_max / j, -b.j_min / j};
}

scaled::Ends Scale::ends(const State& from, const State& to) const noexcept {
  const auto speed = [&](double x) { return std::clamp(x / v, -box.v_down, box.v_up); };
  const auto acceleration = [&](double x) { return std::clamp(x / a, -box.a_down, box.a_up); };
  return {speed(from.v), acceleration(from.a), speed(to.v), acceleration(to.a)};
}

double position_scale(const State& from, const State& to, const AxisBounds& b) noexcept {
  const double a = std::max(b.a_max, -b.a_min), j = std::max(b.j_max, -b.j_min);
  const double left = std::max(std::abs(from.a), std::abs(to.a));
  const double v = std::max(std::abs(from.v), std::abs(to.v)) + left * left / (2 * j);
  return std::max({std::abs(from.p), std::abs(to.p), v * (v / a + std::sqrt(v / j))});
}

std::optional<Phase> one_ramp(const Profile& before, const State& from, const State& to, const AxisBounds& b) noexcept {
  const double p = position_scale(from, to, b), v = std::max(b.v_max, -b.v_min), a = std::max(b.a_max, -b.a_min);
  const bool ramp = std::abs(to.a - from.a) > kSame * a;
  const double jerk = !ramp ? 0 : to.a > from.a ? b.j_max : b.j_min, t = ramp ? (to.a - from.a) / jerk : 0;
  const double p_end = from.p + t * (from.v + t * (from.a / 2 + t * jerk / 6)),
               v_end = from.v + t * (from.a + to.a) / 2;
  const double near = ramp ? kOnRamp : kSame;
  if (std::abs(p_end - to.p) > near * p || std::abs(v_end - to.v) > near * v) return std::nullopt;
  Profile whole = before;
  append(whole, t, jerk);
  const Extent e = extent(whole);
  if (e.low < b.p_min || e.high > b.p_max) return std::nullopt;
  return Phase{t, jerk};
}

double coming_speed(const State& x, const AxisBounds& b, int time_sign) noexcept {
  const double jerk = (x.a > 0) == (time_sign > 0) ? -b.j_min : b.j_max;
  return x.v + time_sign * x.a * std::abs(x.a) / (2 * jerk);
}

Reason problem_of(const State& x, const AxisBounds& b) noexcept {
  if (!std::isfinite(x.p) || !std::isfinite(x.v) || !std::isfinite(x.a)) return Reason::NotFinite;
  for (const double bound : {b.v_max, b.v_min, b.a_max, b.a_min, b.j_max, b.j_min})
    if (!std::isfinite(bound)) return Reason::NotFinite;
  if (std::isnan(b.p_min) || std::isnan(b.p_max)) return Reason::NotFinite;
  if (!(b.a_max > 0) || !(b.a_min < 0) || !(b.j_max > 0) || !(b.j_min < 0) || !(b.p_min < b.p_max))
    return Reason::BadBounds;
  return Reason::Solved;
}

Reason problem_of_target(const State& to, const AxisBounds& b) noexcept {
  if (!std::isfinite(to.p) || !std::isfinite(to.v) || !std::isfinite(to.a)) return Reason::NotFinite;
  if (!(b.v_max > 0) || !(b.v_min < 0)) return Reason::BadBounds;
  // A target with acceleration was faster (or slower) a moment before: that too has to be within the bounds.
  const double before = coming_speed(to, b, -1), grown = 1 + kSlack;
  const bool inside = std::max(to.v, before) <= b.v_max * grown && std::min(to.v, before) >= b.v_min * grown &&
                      to.a <= b.a_max * grown && to.a >= b.a_min * grown && to.p >= b.p_min && to.p <= b.p_max;
  return inside ? Reason::Solved : Reason::TargetOutsideBounds;
}

void append(Profile& profile, const scaled::Shape& shape, const Scale& scale) noexcept {
  for (int i = 0; i < 7; ++i) append(profile, shape.t[i] * scale.t, shape.j[i] * scale.j);
}

// Cut where either changes its jerk.
void append(Profile& profile, const scaled::Mix& mix, const Scale& scale) noexcept {
  if (mix.share >= 1) return append(profile, mix.up, scale);
  if (mix.share <= 0) return append(profile, mix.down, scale);
  int i = 0, k = 0;
  double left_up = mix.up.t[0], left_down = mix.down.t[0];
  for (;;) {
    while (left_up <= 0 && ++i < 7) left_up = mix.up.t[i];
    while (left_down <= 0 && ++k < 7) left_down = mix.down.t[k];
    if (i >= 7 || k >= 7) return;
    const double t = std::min(left_up, left_down);
    append(profile, t * scale.t, (mix.share * mix.up.j[i] + (1 - mix.share) * mix.down.j[k]) * scale.j);
    left_up -= t, left_down -= t;
  }
}

}  // namespace gantry::motion
