// The shortest path along the corners of several paths from one position to another (path hybridization; Raveh, Enosh,
// Halperin 2011): each may be good in another part.
//   auto path = join_paths(paths, clear);   // all have the same ends; never longer than the shortest of them
#pragma once
#include "motion/plan/shorten.hpp"

namespace gantry::motion {

std::vector<Vec3> join_paths(const std::vector<std::vector<Vec3>>& paths, const Clear& clear);

}  // namespace gantry::motion
