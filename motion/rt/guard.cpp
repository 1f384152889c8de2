#include "motion/rt/guard.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {

Verdict check_target(const Limits& limits, const AxisVec& last, const AxisVec& next, int missed_ticks,
                     std::uint32_t axes) noexcept {
  constexpr double kSlack = 1e-6;  // relative to a tick's way, and of a limit: what rounding may add
  const double ticks = 1 + std::max(missed_ticks, 0);
  for (std::size_t i = 0; i < limits.axes; ++i) {
    if ((axes >> i & 1u) == 0) continue;
    const AxisLimits& l = limits.axis[i];
    const AxisId id{static_cast<std::uint8_t>(i)};
    if (!std::isfinite(next[i])) return {Fault::TargetNotFinite, id};
    const double step = l.v_max * limits.tick_s;
    if (!(std::abs(next[i] - last[i]) <= step * ticks * (1 + kSlack))) return {Fault::TargetStep, id};
    // What stands outside (it was switched on there) may stay and come back, but not go further out.
    if ((next[i] > l.p_max + step * kSlack && next[i] > last[i]) ||
        (next[i] < l.p_min - step * kSlack && next[i] < last[i]))
      return {Fault::SoftLimit, id};
  }
  return {};
}

}  // namespace gantry::motion
