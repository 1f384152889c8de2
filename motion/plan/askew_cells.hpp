// A path by cells (cells.hpp) that lie along a slanted slot instead of across it. Cells along X and Y need as many cuts
// as the slot is longer than wide; in axes that are turned so that the slot lies along one of them it is a single cell.
//   auto points = path_along(pairs, space, {cos, sin}, start, goal, 10000);
#pragma once
#include <vector>

#include "motion/plan/cells.hpp"

namespace gantry::motion {

/// What keeps the head from a region: a pair and its margin.
struct KeptApart {
  Difference difference;
  double margin_mm = 0;
};

/// Within `space`, both ends included; empty where none was found. It is no proof: the caller looks at each line.
std::vector<Vec3> path_along(const std::vector<KeptApart>& pairs, const Cell& space, Vec2 x, Vec3 from, Vec3 to,
                             std::size_t most_cuts);

}  // namespace gantry::motion
