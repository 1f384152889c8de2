// Two trees of random positions that grow towards each other (RRTConnect of OMPL). The only file with headers of OMPL
// is its source.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "motion/plan/shorten.hpp"

namespace gantry::motion {

/// A path through the box from `low` to `high`, or nothing after so many iterations. The same seed gives the same path,
/// in every process.
std::vector<Vec3> random_tree(const Clear& clear, Vec3 low, Vec3 high, Vec3 from, Vec3 to, std::uint64_t seed,
                              int iterations);

/// The same with a turn as fourth number, in mm of the point that it moves farthest.
using Turned = std::array<double, 4>;
using ClearTurned = std::function<bool(const Turned&, const Turned&)>;
std::vector<Turned> random_turning_tree(const ClearTurned& clear, const Turned& low, const Turned& high,
                                        const Turned& from, const Turned& to, std::uint64_t seed, int iterations);

}  // namespace gantry::motion
