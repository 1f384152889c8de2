// Axes that arrive together, or each by itself. The position interface (OpenTrajectory) and the velocity interface
// share this: each axis brings a trajectory whose duration is still open.
//   arrive<OpenTrajectory>(axes, how, out, [&](auto& all, const AxisMove& m) { all.emplace_back(m.from, m.to, ...); });
// Such a trajectory has reason(), shortest_s(), first_s(t), write(t, profile) and reason_of_none(), as in
// open_trajectory.hpp.
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

/// First duration >= least, on the grid, that every one of the trajectories can take; negative: none was found.
template <class AnyTrajectory>
[[nodiscard]] double common_duration(std::span<AnyTrajectory> trajectories, double least, double cycle_s) noexcept {
  constexpr int kMostRounds = 64;  // each axis has two gaps at most; a grid may take a few tries over each
  double t = on_grid(least, cycle_s);
  for (int round = 0; round < kMostRounds; ++round) {
    double need = t;
    for (AnyTrajectory& trajectory : trajectories) {
      const double first = trajectory.first_s(t);
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

/// Fills `out`, whose axes are known to be valid. `add(trajectories, move)` appends the trajectory of one axis.
template <class AnyTrajectory, class Add>
void arrive(std::span<const AxisMove> axes, const Together& how, Joint& out, Add add) noexcept {
  rt::FixedVector<AnyTrajectory, kMaxAxes> trajectories;  // of the axes that are enabled
  double longest = std::max(how.min_duration_s, 0.0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    out.profiles.push_back({axes[i].from, {}});
    if (!axes[i].enabled) continue;
    const AnyTrajectory& trajectory = add(trajectories, axes[i]);
    if (trajectory.reason() != Reason::Solved) return fail(out, trajectory.reason(), i);
    longest = std::max(longest, trajectory.shortest_s());
  }
  const bool together = how.sync != Sync::None;
  const double common = together ? common_duration(std::span(trajectories), longest, how.cycle_s) : 0;
  AnyTrajectory* trajectory = trajectories.begin();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!axes[i].enabled) continue;
    const double least = std::max(how.min_duration_s, trajectory->shortest_s());
    const double t = together ? common : common_duration(std::span(trajectory, 1), least, how.cycle_s);
    if (t < 0 || !trajectory->write(t, out.profiles[i])) return fail(out, trajectory->reason_of_none(), i);
    out.duration_s = std::max(out.duration_s, t);
    ++trajectory;
  }
  out.reason = Reason::Solved;
}

}  // namespace gantry::motion
