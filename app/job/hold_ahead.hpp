// When the tool will stand that a hold lets come to the end of its feature: the valve shuts as planned, the hold is
// carried out when the drives have come to where it did, and the tool brakes from there: on its run-out, or on its way
// back along the bead.
//   const double left_s = stands_in_s(block.segments(), {snapshot.along_block_mm, 0.04}, feature, override, limits);
#pragma once
#include <cstdint>
#include <deque>

#include "motion/types.hpp"

namespace gantry::job {

/// Where the tool is.
struct InBlock {
  double along_mm = 0;  ///< from the block's start
  double stands_s = 0;  ///< for how long it has stood there by plan: so much of what it waits for there is gone
};

/// In s from there. `rate`: of planned time, 0..1; it makes no standstill longer. Of a feature that has no valve left
/// to shut: how long the drives are behind.
[[nodiscard]] double stands_in_s(const std::deque<motion::Segment>& block, InBlock at, std::uint32_t feature,
                                 double rate, const motion::Limits& limits);

}  // namespace gantry::job
