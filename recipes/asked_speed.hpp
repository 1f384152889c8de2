// What a bead is asked for on a machine: its material's speed, and how fast the axes that lay it may change it.
//   SteadySpeed judge(asked_speed(machine, bead.points, m.speed, m.speed_tolerance), 0.001);
#pragma once
#include <algorithm>
#include <cmath>
#include <span>

#include "config/machine.hpp"
#include "core/steady_speed.hpp"
#include "core/vec.hpp"

namespace gantry::recipes {

/// `points`: of the bead, z over its board. The axes are X and Y, and Z by as much as it takes part where the bead is
/// steepest.
[[nodiscard]] inline AskedSpeed asked_speed(const config::Machine& machine, std::span<const Vec3> points,
                                            double speed_mm_s, double tolerance) {
  double climbs = 0;  // sine of its slope
  for (std::size_t i = 1; i < points.size(); ++i)
    if (const Vec3 leg = points[i] - points[i - 1]; norm(leg) > 0)
      climbs = std::max(climbs, std::abs(leg.z) / norm(leg));
  const auto slowest = [&](double config::Axis::*limit) {
    const auto of = [&](AxisId id) { return machine.axes[id.value].*limit; };
    const double level = std::min(of(machine.x), of(machine.y));
    return climbs > 0 ? std::min(level, of(machine.z) / climbs) : level;
  };
  return {speed_mm_s, tolerance, slowest(&config::Axis::a_max), slowest(&config::Axis::j_max)};
}

}  // namespace gantry::recipes
