// How far a convex body that is moved along a straight line stays from one that stands: exact, no sampling.
//   Gap g = gap(needle, {40, 0, 0}, part, 2.0);    // decides at 2 mm
//   g.lower > 2.0: free, and g.direction proves it: between the planes across it there is that much room
// Where the motion has come to, the distance has a closed form (difference.hpp). Along the motion it is convex and,
// while the bodies are apart, smooth: each look gives a tangent, two tangents the next place to look at. Near the
// minimum the planes that contain the motion are tried too: one of them parts what is apart by next to nothing.
#pragma once
#include <limits>

#include "motion/plan/solid.hpp"

namespace gantry::motion {

struct Gap {
  double lower = -std::numeric_limits<double>::infinity();  ///< proved by `direction`; mm
  double upper = std::numeric_limits<double>::infinity();   ///< two points that near exist; mm
  Vec3 direction{0, 0, 1};                                  ///< unit, from the moving body to the standing one
  double fraction = 0;                                      ///< of the motion, where they are `upper` apart
};

/// Stops when lower > decide_at or upper <= decide_at. `measure_gap` goes on until both are as near as numbers allow
/// (1e-7 mm or better where the bodies are apart; where they overlap, upper <= 0 and no lower bound).
Gap gap(const Solid& moving, Vec3 sweep, const Solid& standing, double decide_at);
Gap measure_gap(const Solid& moving, Vec3 sweep, const Solid& standing);
/// Measures, but gives up (upper is at least `known_mm` then) as soon as it is sure that they come no nearer than that.
Gap gap_below(const Solid& moving, Vec3 sweep, const Solid& standing, double known_mm);

/// The first share of the motion at which the two are as near as `margin_mm`; 1 when they never are.
double first_contact(const Solid& moving, Vec3 sweep, const Solid& standing, double margin_mm);

/// A point of the standing body that is nearest to the moving one where it is; of overlapping bodies one that both
/// share.
Vec3 nearest_point(const Solid& moving, const Solid& standing);

}  // namespace gantry::motion
