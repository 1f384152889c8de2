// Somebody else's opinion of motions that were proved free: FCL is asked for contact at poses along them.
//   const Opinion fcl = fcl_opinion();   auto poses = fcl(scene, rules, segments);   // Result: how many it looked at
// It proves nothing, for it sees nothing between two poses; but it shares no code with the proof and its check, so that
// a mistake in these has to be made twice. Only FCL's boolean contact is asked, which was right in every case tried;
// its distances and continuous queries were not (docs/motion/planning.md).
#pragma once
#include <functional>
#include <span>

#include "core/error.hpp"
#include "motion/plan/certificate.hpp"
#include "motion/plan/scene.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

/// Of segments that were proved free in this scene by these rules: the number of poses that were looked at.
/// Fault::Internal when bodies meet that are to keep apart, with both verdicts, the bodies and the point.
using Opinion =
    std::function<Result<std::size_t>(const Scene& scene, const ClearanceRules& rules, std::span<const Segment> all)>;

/// Between two poses no body of the head goes farther.
inline constexpr double kOpinionStep_mm = 1;

/// Pairs that the rules let near are not asked. Keeps the last scenes as FCL has them; one thread at a time.
Opinion fcl_opinion();

}  // namespace gantry::motion
