// Distances and lengths as they are seen from above: the height, which has a tolerance of its own, left out.
#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/vec.hpp"

namespace gantry::record {

inline double from_above_mm(Vec3 a, Vec3 b) { return std::hypot(a.x - b.x, a.y - b.y); }

inline double length_from_above_mm(const std::vector<Vec3>& path) {
  double mm = 0;
  for (std::size_t i = 1; i < path.size(); ++i) mm += from_above_mm(path[i - 1], path[i]);
  return mm;
}

}  // namespace gantry::record
