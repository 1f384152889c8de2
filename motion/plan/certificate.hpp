// Proof that a polyline of the axes is free, and how near it comes to what stands there.
//   Result<Certificate> c = certify(scene, points, {.clearance_mm = 2, .approaches = {...}}, corner_tolerance_mm);
// Corner blends stay within the corner's hull, at most the tolerance off its legs: the legs with the tolerance added to
// the clearance cover them. (An allowed approach keeps what it says: a blend in the plane of its legs stays
// as high over the board.)
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/breath.hpp"
#include "core/error.hpp"
#include "motion/plan/sweep.hpp"

namespace gantry::motion {

struct ClearanceRules {
  double clearance_mm = 2;                  ///< from every body, over and above path deviation
  std::vector<AllowedApproach> approaches;  ///< pairs that may come nearer
};

/// One straight motion of a certified polyline.
struct MotionProof {
  AxisVec from{}, to{};
  std::size_t pairs = 0;        ///< pairs checked
  std::string head, standing;   ///< the nearest pair
  double min_clearance_mm = 0;  ///< distance that it keeps; infinite in an empty scene
};

struct Certificate {
  std::uint64_t scene_hash = 0;
  double clearance_mm = 0, extra_mm = 0;  ///< what was asked
  std::vector<MotionProof> motions;
  std::size_t pairs = 0;
  double min_clearance_mm = 0;
};

/// Fault::Collision with both bodies, the point and the number of the motion; Fault::Internal when the second check
/// contradicts the first; Fault::UnknownReference for an allowed approach that names a body which is not there;
/// Fault::Aborted when the breath, which is asked between two motions, says no.
Result<Certificate> certify(const Scene& scene, std::span<const AxisVec> polyline, const ClearanceRules& rules,
                            double extra_mm = 0, const Breath& breath = {});

/// "needle meets part U7 at (120.0, 80.0, 21.5), clearance 2 mm"
std::string describe(const Scene& scene, const Hit& hit);

}  // namespace gantry::motion
