// The second check: is a pair really apart along the direction that the first check names? Two extents and two dot
// products, none of the first check's code, so that "free" rests on these lines and not on GJK.
//   assert(holds(scene, from, to, proof, margin))
#pragma once
#include "motion/plan/sweep.hpp"

namespace gantry::motion {

bool holds(const Scene& scene, const AxisVec& from, const AxisVec& to, const PairProof& proof, double margin_mm);

}  // namespace gantry::motion
