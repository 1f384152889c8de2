// Axes that arrive together, or each by itself, whatever their ways are made of: the position interface (Way) and the
// velocity interface share it.
//   arrive<Way>(axes, how, out, [&](auto& ways, const AxisMove& m) { ways.emplace_back(m.from, m.to, ...); });
// A way has reason(), shortest_s(), first_s(t), write(t, profile) and reason_of_none(), as in way.hpp.
#pragma once
#include <algorithm>
#include <cmath>
#include <span>

#include "core/rt/fixed_vector.hpp"
#include "motion/profile/scale.hpp"
#include "motion/profile/together.hpp"

namespace gantry::motion {

/// t rounded up to a multiple of the cycle; cycle 0: t.
[[nodiscard]] inline double on_grid(double t, double cycle_s) noexcept {
  return cycle_s > 0 ? std::ceil(t / cycle_s * (1 - kEqual)) * cycle_s : t;
}

/// First duration >= least, on the grid, that none of the ways has blocked; negative: none was found.
template <class AnyWay>
[[nodiscard]] double common_duration(std::span<AnyWay> ways, double least, double cycle_s) noexcept {
  constexpr int kMostRounds = 64;  // each axis has two gaps at most; a grid may take a few tries over each
  double t = on_grid(least, cycle_s);
  for (int round = 0; round < kMostRounds; ++round) {
    double need = t;
    for (AnyWay& way : ways) {
      const double first = way.first_s(t);
      if (first < 0) return -1;
      need = std::max(need, first);
    }
    if (need <= t * (1 + kEqual)) return t;
    t = on_grid(need, cycle_s);
  }
  return -1;
}

/// Nothing of a motion is left in `out` but why there is none.
inline void fail(Joint& out, Reason reason, std::size_t axis) noexcept {
  out.profiles.clear();
  out.duration_s = 0;
  out.reason = reason;
  out.axis = static_cast<std::uint8_t>(axis);
}

/// What does not concern one axis alone. False: `out` says what is wrong.
[[nodiscard]] inline bool check(std::span<const AxisMove> axes, const Together& how, Joint& out) noexcept {
  if (axes.size() > kMaxAxes)
    fail(out, Reason::BadBounds, kMaxAxes);
  else if (!std::isfinite(how.min_duration_s) || !std::isfinite(how.cycle_s))
    fail(out, Reason::NotFinite, 0);
  else
    return true;
  return false;
}

/// Fills `out`, whose axes are known to be valid. `add(ways, move)` appends the way of one axis.
template <class AnyWay, class Add>
void arrive(std::span<const AxisMove> axes, const Together& how, Joint& out, Add add) noexcept {
  rt::FixedVector<AnyWay, kMaxAxes> ways;  // of the axes that are enabled
  double longest = std::max(how.min_duration_s, 0.0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    out.profiles.push_back({axes[i].from, {}});
    if (!axes[i].enabled) continue;
    const AnyWay& way = add(ways, axes[i]);
    if (way.reason() != Reason::Solved) return fail(out, way.reason(), i);
    longest = std::max(longest, way.shortest_s());
  }
  const bool together = how.sync != Sync::None;
  const double common = together ? common_duration(std::span(ways), longest, how.cycle_s) : 0;
  AnyWay* way = ways.begin();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!axes[i].enabled) continue;
    const double least = std::max(how.min_duration_s, way->shortest_s());
    const double t = together ? common : common_duration(std::span(way, 1), least, how.cycle_s);
    if (t < 0 || !way->write(t, out.profiles[i])) return fail(out, way->reason_of_none(), i);
    out.duration_s = std::max(out.duration_s, t);
    ++way;
  }
  out.reason = Reason::Solved;
}

}  // namespace gantry::motion
