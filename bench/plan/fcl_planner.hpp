// What one gets from OMPL and FCL as they come: RRTConnect and simplification, motions sampled every 0.5 mm.
#pragma once
#include <vector>

#include "bench/plan/fcl_scene.hpp"

namespace gantry::bench {

/// Empty when none was found within a second.
std::vector<Vec3> fcl_plan(FclScene& scene, Vec3 low, Vec3 high, Vec3 from, Vec3 to);

}  // namespace gantry::bench
