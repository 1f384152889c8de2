// How far a convex body that is swept along a straight line stays from one that stands. For translation the swept body
// is convex itself, its support is the body's plus that of the line, so one convex query answers exactly: no sampling.
//   Gap g = gap(needle, {40, 0, 0}, part, 2.0);    // decides at 2 mm
//   g.lower > 2.0: free, and g.direction proves it: between the planes across it there is that much room
// GJK (Gilbert, Johnson, Keerthi 1988) in double precision and mm; each iteration gives a lower bound (with its
// direction) and an upper bound of the distance, so that it may stop as soon as the question is answered.
#pragma once
#include <limits>

#include "motion/plan/solid.hpp"

namespace gantry::motion {

struct Gap {
  double lower = -std::numeric_limits<double>::infinity();  ///< proved by `direction`; mm
  double upper = std::numeric_limits<double>::infinity();   ///< two points that near exist; mm
  Vec3 direction{0, 0, 1};                                  ///< unit, from the moving body to the standing one
  Vec3 on_moving, on_standing;                              ///< nearest points, when lower and upper meet above 0
};

/// Stops when lower > decide_at or upper <= decide_at. Without `decide_at` it measures: upper - lower <= 1e-7 mm.
Gap gap(const Solid& moving, Vec3 sweep, const Solid& standing, double decide_at);
Gap measure_gap(const Solid& moving, Vec3 sweep, const Solid& standing);

}  // namespace gantry::motion
