// The fairest cubic spline through a tube around a polyline: the one whose curvature changes most evenly.
//   FairSpline s;  if (fair(measure, guide, begin, end, knots, s)) ... s.bezier(i) ...
// Minimises the integral of |q'''|^4 (its peaks are what the jerk limit lets pass only slowly) while q(s) stays within
// the tube's room of the polyline's point at the same s.
// Knots are added where that takes more of them. What is returned was measured to lie in the tube.
#pragma once
#include <array>
#include <vector>

#include "motion/path/curve.hpp"

namespace gantry::motion {

/// A stretch of polyline, and how far the spline may leave it.
struct Guide {
  std::vector<double> at;       ///< length at each vertex, rising
  std::vector<AxisVec> q;       ///< the vertices
  std::vector<double> room_mm;  ///< on the leg that begins at the vertex
};

/// Control k belongs to knots[k + 1]; there is one more knot at either end. Curves run from control 1 to the last but
/// one.
struct FairSpline {
  std::vector<double> knots;
  std::vector<AxisVec> controls;

  [[nodiscard]] std::size_t intervals() const { return controls.size() - 3; }
  [[nodiscard]] double begin_of(std::size_t interval) const { return knots[interval + 2]; }
  /// Bezier points between two knots.
  [[nodiscard]] std::array<AxisVec, 4> bezier(std::size_t interval) const;
};

enum class FairEnd : std::uint8_t {
  OnLeg,  ///< on the polyline, with its direction and no curvature
  Free,   ///< on the polyline
  Given,  ///< the spline goes on from another one: its first three controls and five knots stay as they are
};

/// knots: from the guide's first to its last length (begin Given: those that follow the spline's five).
/// False: no spline was found that stays in the tube.
[[nodiscard]] bool fair(const Measure& m, const Guide& guide, FairEnd begin, FairEnd end, std::vector<double> knots,
                        FairSpline& spline);

}  // namespace gantry::motion
