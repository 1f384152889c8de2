// The fastest speed over a stretch of path: v and its derivative at the ends of cells of arc length, so that no axis
// breaks its limits, over the whole stretch at once.
//   PaceProblem p;  ... p.cells ...;  Pace found = fastest(p);          // if (!found.solved) -> plan slower, or fail
// Off the RT side. Work is linear in the number of cells.
#pragma once
#include <vector>

#include "motion/path/curve.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

/// Derivatives of the path at both ends of a cell, from within the cell.
struct PaceCell {
  double length = 0;
  double share = 1;    ///< of the limits that may be used here (speeds; squared and cubed for the others)
  double v_guess = 0;  ///< at its end: a rough upper estimate, > 0 but at a rest
  bool straight = false;
  // How speed grows within it, where that matters (near a rest): a = a0 + (a1 - a0) (t - t0)/(t1 - t0) integrates to
  // length ((1 - weight) a0 + weight a1), and its mean speed is so many times the speed at its ends.
  double weight = 0.5, mean_by_begin = 1, mean_by_end = 1;
  double mean_before_middle = 1, mean_after_middle = 1;  ///< the same for the speed in its middle, in both halves
  CurveJet begin, middle, end;                           ///< of a straight cell only d1 of `begin` counts
};

struct PaceProblem {
  std::vector<PaceCell> cells;
  Limits limits;
  double v_set = 0;       ///< of the tool
  bool from_rest = true;  ///< else the start is free. The end is at rest.
  /// The speed stays below its limit between nodes as well, at a small price: where changes of jerk from cell to cell
  /// raise it there by more than the limits allow.
  bool hull = false;
};

/// Speed and its derivative by time at a node between cells.
struct PaceNode {
  double v = 0, a = 0;
};

struct Pace {
  bool solved = false;          ///< within the limits, and the fastest as far as the search came
  std::vector<PaceNode> nodes;  ///< cells + 1
  std::vector<double> spline;   ///< of v^2, for a next try
  int steps = 0;
};

/// `near`: an earlier result for the same cells and start with other shares, from which it is not far.
[[nodiscard]] Pace fastest(const PaceProblem& problem, const Pace* near = nullptr);

}  // namespace gantry::motion
