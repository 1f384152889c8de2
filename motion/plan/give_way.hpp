// A way that was found before leads along bodies at the very clearance: where it, or what it leads along, lies
// elsewhere by tenths of a millimetre, its corners give way by so much.
//   if (auto way = give_way(scene, ways, margins)) ...
#pragma once
#include <optional>
#include <vector>

#include "motion/plan/sweep.hpp"

namespace gantry::motion {

/// Of these ways, which have the same ends, the first one that is free with its corners moved as little as it takes, by
/// 2 mm at most: free of bodies, within the axes' limits, and as high as it has to be. Nothing: none is.
std::optional<std::vector<AxisVec>> give_way(const Scene& scene, const std::vector<std::vector<AxisVec>>& ways,
                                             const Margins& margins);

}  // namespace gantry::motion
