// Two trees of random positions that grow towards each other (RRTConnect of OMPL). The only file with headers of OMPL
// is its source.
#pragma once
#include <cstdint>
#include <vector>

#include "motion/plan/shorten.hpp"

namespace gantry::motion {

/// A path through the box from `low` to `high`, or nothing after so many iterations. The same seed gives the same path,
/// in every process.
std::vector<Vec3> random_tree(const Clear& clear, Vec3 low, Vec3 high, Vec3 from, Vec3 to, std::uint64_t seed,
                              int iterations);

}  // namespace gantry::motion
