// The shortest way along corners of several ways from one place to another (path hybridization; Raveh, Enosh, Halperin
// 2011): each may be good in another part.
//   auto way = join_ways(ways, clear);   // all have the same ends; never longer than the shortest of them
#pragma once
#include "motion/plan/shorten.hpp"

namespace gantry::motion {

std::vector<Vec3> join_ways(const std::vector<std::vector<Vec3>>& ways, const Clear& clear);

}  // namespace gantry::motion
