// A lower bound of the time from rest to rest of any motion that comes, in their order, within 1.5 times the tolerance
// of every point of a polyline. It counts speeds and accelerations of single axes, not jerk and not how axes hinder
// each other in a bend: true, but not tight (about 1.13 s for the circle of the table in docs/motion/path.md, which
// takes 1.3 s).
#pragma once
#include <array>
#include <vector>

namespace gantry::bench {

struct BoundLimits {
  double v = 0, a = 0;  ///< of each axis
  double speed = 0;     ///< of the tool; may be infinite
  double tolerance = 0;
};

double bound_s(const std::vector<std::array<double, 3>>& points, const BoundLimits& limits);

}  // namespace gantry::bench
