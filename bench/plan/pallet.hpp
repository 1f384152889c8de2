// A head of four bodies over a pallet of boxes and cylinders, and questions about it; seeded.
#pragma once
#include <cstdint>
#include <random>
#include <vector>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "motion/plan/scene.hpp"

namespace gantry::bench {

/// Needle capsule, syringe cylinder, camera box, probe capsule; 400 x 300 mm, 100 mm high.
config::Machine pallet(int parts, std::uint64_t seed);

struct Line {
  AxisVec from{}, to{};
};
/// Lines between positions that are free, anywhere over the pallet; `blocked_only`: those that a body blocks.
std::vector<Line> lines(const motion::Scene& scene, int count, std::uint64_t seed, bool blocked_only);

}  // namespace gantry::bench
