#include "motion/profile/together.hpp"

#include "motion/profile/arrive.hpp"
#include "motion/profile/open_trajectory.hpp"
#include "motion/profile/straight.hpp"

namespace gantry::motion {

Joint move_together(std::span<const AxisMove> axes, const Together& how) noexcept {
  Joint out;
  if (!check(axes, how, out)) return out;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!axes[i].enabled) continue;
    Reason reason = problem_of(axes[i].from, axes[i].bounds);
    if (reason == Reason::Solved) reason = problem_of_target(axes[i].to, axes[i].bounds);
    if (reason == Reason::Solved) continue;
    fail(out, reason, i);
    return out;
  }
  if (how.sync == Sync::Phase && move_straight(axes, how, out)) return out;
  arrive<OpenTrajectory>(axes, how, out, [&how](auto& trajectories, const AxisMove& m) -> OpenTrajectory& {
    return trajectories.emplace_back(m.from, m.to, m.bounds, how.outside);
  });
  return out;
}

}  // namespace gantry::motion
