// When the tool will stand that a hold lets come to the end of its feature: the valve shuts as planned, the hold is
// carried out when the drives have come to where it did, and the tool brakes from there: on its run-out, or on its way
// back along the bead.
//   const double left_s = stands_in_s(block.segments(), snapshot.along_block_mm, feature, override, limits);
#pragma once
#include <cstdint>
#include <deque>

#include "motion/types.hpp"

namespace gantry::job {

/// In s from where the tool is, `along_block_mm` from the block's start; of a dot the whole of its time counts.
/// `rate`: of planned time, 0..1. Of a feature that has no valve left to shut: how long the drives are behind.
[[nodiscard]] double stands_in_s(const std::deque<motion::Segment>& block, double along_block_mm, std::uint32_t feature,
                                 double rate, const motion::Limits& limits);

}  // namespace gantry::job
