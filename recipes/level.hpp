// Whether a bead stays at one height over its board: then rounding its corners changes no gap, and Z has no part in it.
#pragma once
#include <algorithm>
#include <span>

#include "core/vec.hpp"

namespace gantry::recipes {

[[nodiscard]] inline bool is_level(std::span<const Vec3> points) {
  return std::all_of(points.begin(), points.end(), [&](Vec3 p) { return p.z == points.front().z; });
}

}  // namespace gantry::recipes
