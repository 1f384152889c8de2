// The path of the tips for a drawing in space: thinned to within a bound that is told, however long the job was.
//   TipLines lines = tip_lines(result);
// One line a block for where the tip of its tool went; over it what it did with the valve open: beads as lines, dots as
// points. Machine frame.
#pragma once
#include <span>
#include <vector>

#include "app/record/job_result.hpp"

namespace gantry::record {

struct TipLines {
  std::vector<std::vector<Vec3>> travel, beads;
  std::vector<Vec3> dots;
  double within_mm = 0;        ///< no point of the path is farther from the lines than this
  std::size_t every_bead = 1;  ///< drawn: each, every second ...
  std::size_t every_dot = 1;
};

/// Of the actual path, or of the planned one where nothing moved. Points that are no numbers are left out.
TipLines tip_lines(const JobResult& result);

/// Features as the recipe asks for them, thinned in the same way; nothing in `travel`.
TipLines asked_lines(const JobResult& result);

/// A part of the points, the first and the last among them, such that every other point is within `tolerance_mm` of the
/// line (Douglas & Peucker 1973, in pieces of bounded length, so that it takes no time to speak of).
std::vector<Vec3> simplified(std::span<const Vec3> points, double tolerance_mm);

}  // namespace gantry::record
