// The least time from rest to rest on given curves, each axis within its speed, acceleration and jerk: dynamic
// programming over speed and acceleration at places along the path, which shares nothing with the planner but the
// curves.
//   optimum_s(stretch.curves, limits, {.speeds = 90, .accelerations = 91, .jerks = 21})
// It is true to about 1 % at these grids: limits are looked at where places are, and in between values are
// interpolated.
#pragma once
#include <span>

#include "motion/path/curve.hpp"
#include "motion/types.hpp"

namespace gantry::bench {

struct OptimumGrid {
  std::size_t speeds = 90, accelerations = 91, jerks = 21;
  double place_s = 0.004;  ///< from place to place, about
};

[[nodiscard]] double optimum_s(std::span<const motion::Curve> curves, const motion::Limits& limits,
                               const OptimumGrid& grid);

}  // namespace gantry::bench
