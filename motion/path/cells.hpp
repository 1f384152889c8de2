// Divides a chain of curves into the cells on which its speed is planned: fine where the tool is slow, about one for
// every few milliseconds elsewhere.
#pragma once
#include <span>
#include <vector>

#include "motion/path/pace.hpp"

namespace gantry::motion {

struct CellGrid {
  std::vector<PaceCell> cells;
  std::vector<std::size_t> curve_end;  ///< number of cells up to the end of each curve
};

/// v0: at the start; the end is a rest.
[[nodiscard]] CellGrid divide(std::span<const Curve> curves, const Limits& limits, double v_set, double v0);

/// Least time that the curves may take, roughly.
[[nodiscard]] double rough_seconds(const Curve& curve, const Limits& limits, double v_set);

}  // namespace gantry::motion
