// The last look at motion before it is queued: segments as the loop will play them, whatever has made them. It
// integrates their phases and differentiates their axes by power series (series.hpp), and shares nothing with what
// plans.
//   if (const auto why = unsound(limits, segments)) return fail(Fault::Internal, *why);
// Off the RT side.
#pragma once
#include <optional>
#include <span>
#include <string>

#include "motion/types.hpp"

namespace gantry::motion {

/// Nothing: the segments go from rest to rest without a jump of position, or, but at rests, of any axis' speed or
/// acceleration; s stays within each one's length, ends there and never goes back; every axis keeps its limits x 1.001,
/// and `capped`, which is a part of them, its `v_cap` x 1.001. Else what does not hold first, with the segment's
/// number.
[[nodiscard]] std::optional<std::string> unsound(const Limits& limits, std::span<const Segment> segments,
                                                 std::span<const Segment> capped = {});

}  // namespace gantry::motion
