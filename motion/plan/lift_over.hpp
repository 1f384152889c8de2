// Up, across, down at the lowest Z that is free. Computed: each body that is met forbids one interval of heights (the
// swept bodies are convex), so climbing out of each in turn ends at the lowest height that none forbids.
//   auto over = lift_over(scene, from, to, margins);
#pragma once
#include <string>
#include <vector>

#include "motion/plan/sweep.hpp"

namespace gantry::motion {

struct LiftOver {
  std::vector<AxisVec> points;  ///< from, above it, above the goal, to (ends that are already that high stand once)
  double z_mm = 0;              ///< Z of the motion across
};
struct NoLiftOver {
  std::string why;  ///< "the motion up: needle meets beam at ...", "Z 92.1 mm would be needed, its limit is 80 mm"
};

/// The lift U goes up with Z before the motion across and down with it after.
tl::expected<LiftOver, NoLiftOver> lift_over(const Scene& scene, const AxisVec& from, const AxisVec& to,
                                             const Margins& margins);

}  // namespace gantry::motion
