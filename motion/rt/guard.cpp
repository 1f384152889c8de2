#include "motion/rt/guard.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {

Verdict check_target(const Limits& limits, const AxisVec& before_last, const AxisVec& last, const AxisVec& next,
                     int missed_ticks, std::uint32_t axes) noexcept {
  constexpr double kSlack = 1e-6;        // relative to a tick's displacement, and of a limit: what rounding may add
  constexpr double kPlanned = 1 + 1e-3;  // of the acceleration: what the planner's own inspection lets pass
  constexpr double kRounding = 1e-15;    // of a position, four of which make a difference of steps
  // A delayed target lies on a cubic between two samples, and where the jerk jumps by up to 2 j it is off by up to
  // 2 j h^3 / 192; two in a row may differ by twice that (compensation.cpp).
  const double cubic = limits.tick_s * limits.tick_s * limits.tick_s / 48;
  const double ticks = 1 + std::max(missed_ticks, 0);
  for (std::size_t i = 0; i < limits.axes; ++i) {
    if ((axes >> i & 1u) == 0) continue;
    const AxisLimits& l = limits.axis[i];
    const AxisId id{static_cast<std::uint8_t>(i)};
    if (!std::isfinite(next[i])) return {Fault::TargetNotFinite, id};
    const double step = l.v_max * limits.tick_s;
    const double slack = step * kSlack + l.j_max * cubic;
    if (!(std::abs(next[i] - last[i]) <= (step + slack) * ticks)) return {Fault::TargetStep, id};
    // What stands outside (it was switched on there) may stay and come back, but not go further out in one tick or two
    // than a delayed target that begins to come back swings out (see above).
    const double out = l.j_max * cubic + kRounding * std::abs(next[i]);
    if ((next[i] > l.p_max + slack && next[i] > std::min(last[i], before_last[i]) + out) ||
        (next[i] < l.p_min - slack && next[i] < std::max(last[i], before_last[i]) - out))
      return {Fault::SoftLimit, id};
    // A step is the mean speed over its ticks; the middles of the two are (ticks + 1) / 2 apart. Of a delayed target
    // the difference of steps may be off by twice what a step may (see above).
    const double change = (next[i] - last[i]) / ticks - (last[i] - before_last[i]);
    const double allowed = l.a_max * limits.tick_s * limits.tick_s * kPlanned * (ticks + 1) / 2;
    const double rounding = 2 * l.j_max * cubic + 4 * kRounding * std::abs(next[i]);
    if (!(std::abs(change) <= allowed + rounding)) return {Fault::TargetStep, id};
  }
  return {};
}

}  // namespace gantry::motion
