// Whether a motion stays within the soft limits, at the ends of its segments and where they bend.
//   if (const auto out = beyond_limits(limits, segments)) ... out->axis, out->by
#pragma once
#include <optional>
#include <span>

#include "motion/types.hpp"

namespace gantry::motion {

/// Which axis leaves its soft limits, and by how much, mm or rad.
struct Beyond {
  std::size_t axis = 0;
  double by = 0;
};
/// Of the first segment in which one does.
[[nodiscard]] std::optional<Beyond> beyond_limits(const Limits& limits, std::span<const Segment> segments);

}  // namespace gantry::motion
