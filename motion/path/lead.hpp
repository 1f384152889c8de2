// What leads to a path and away from it: on its tangent, bent as the path is bent at its end, then straight on.
//   lead_in(measure, jet(first, 0, axes), 6.2, 3.1, {z, 0.6})    // 6.2 mm long, bent over 3.1 of them, from 0.6 above
//   lead_out(measure, jet(last, last.length, axes), 6.2, 3.1)
// Off the RT side.
#pragma once
#include <vector>

#include "motion/path/curve.hpp"

namespace gantry::motion {

/// How high above the path's end a lead starts, and on which axis that counts.
struct Lift {
  std::size_t axis = 0;
  double mm = 0;
  double slope = 0.3;  ///< of the steepest part of the descent, at its start
};

/// Curves to `at`, the one that is farther from it first. With l = the length that is left along its tangent:
///   bent part      q - q' l + q'' (l^2 / 2 - l^3 / (6 b)),  l in [0, b]: its curvature at `at`, and none at l = b
///   straight part  straight on from there, up to l = length_mm
///   both           lift (l / length_mm)^3 higher, which has no direction and no curvature at `at`.
[[nodiscard]] std::vector<Curve> lead_in(const Measure& measure, const CurveJet& at, double length_mm, double bent_mm,
                                         const Lift& lift = {});

/// The same away from `at`, without a lift.
[[nodiscard]] std::vector<Curve> lead_out(const Measure& measure, const CurveJet& at, double length_mm, double bent_mm);

/// How sharply the path is bent there, 1/mm: over its inverse a direction becomes another one. An axis that only
/// follows along is bent as much as it changes its rate.
[[nodiscard]] double bend_of(const Measure& measure, const CurveJet& at);

/// A lead is bent over so much of its length: so many radii, or all of it.
[[nodiscard]] double bent_over_mm(double bend, double radii, double length_mm);

}  // namespace gantry::motion
