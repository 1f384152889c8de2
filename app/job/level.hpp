// Whether a bead stays at one height over its board: then rounding its corners changes no gap.
#pragma once
#include <algorithm>

#include "recipes/recipe.hpp"

namespace gantry::job {

inline bool is_level(const recipes::Bead& bead) {
  return std::all_of(bead.points.begin(), bead.points.end(), [&](Vec3 p) { return p.z == bead.points.front().z; });
}

}  // namespace gantry::job
