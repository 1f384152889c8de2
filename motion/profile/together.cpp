#include "motion/profile/together.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "motion/profile/straight.hpp"
#include "motion/profile/way.hpp"

namespace gantry::motion {
namespace {

Joint failed(Reason reason, std::size_t axis) noexcept {
  Joint out;
  out.reason = reason;
  out.axis = static_cast<std::uint8_t>(axis);
  return out;
}

}  // namespace

Joint move_together(std::span<const AxisMove> axes, const Together& how) noexcept {
  if (axes.size() > kMaxAxes) return failed(Reason::BadBounds, kMaxAxes);
  if (!std::isfinite(how.min_duration_s) || !std::isfinite(how.cycle_s)) return failed(Reason::NotFinite, 0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!axes[i].enabled) continue;
    Reason reason = problem_of(axes[i].from, axes[i].bounds);
    if (reason == Reason::Solved) reason = problem_of_target(axes[i].to, axes[i].bounds);
    if (reason != Reason::Solved) return failed(reason, i);
  }
  Joint out;
  if (how.sync == Sync::Phase && move_straight(axes, how, out)) return out;

  std::array<std::optional<Way>, kMaxAxes> ways;
  double longest = std::max(how.min_duration_s, 0.0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    out.profiles.push_back({axes[i].from, {}});
    if (!axes[i].enabled) continue;
    ways[i].emplace(axes[i].from, axes[i].to, axes[i].bounds, how.outside);
    if (ways[i]->reason() != Reason::Solved) return failed(ways[i]->reason(), i);
    longest = std::max(longest, ways[i]->shortest_s());
  }
  const std::span all(ways.data(), axes.size());
  const bool together = how.sync != Sync::None;
  const double common = together ? common_duration(all, longest, how.cycle_s) : 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!ways[i]) continue;
    const double t =
        together ? common
                 : common_duration(all.subspan(i, 1), std::max(how.min_duration_s, ways[i]->shortest_s()), how.cycle_s);
    if (t < 0 || !ways[i]->write(t, out.profiles[i])) return failed(ways[i]->reason_of_none(), i);
    out.duration_s = std::max(out.duration_s, t);
  }
  out.reason = Reason::Solved;
  return out;
}

}  // namespace gantry::motion
