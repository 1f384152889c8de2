// A corner rounded by a polynomial: the tangent turns from d1 to d2 by q' = d1 (1 - w) + d2 w, w(u) = 3u^2 - 2u^3.
//   double d = blend_reach(d1, d2, tolerance);             // how far before and after the corner it may begin and end
//   Geometry g = blend(corner, d1, d2, d);  Bounds b = blend_bounds(limits, d1, d2, d, v_wanted);
// s runs over 2 d: like the polyline it replaces, faster than the arc by up to cos(half the turn).
#pragma once
#include "motion/profile/planner.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

/// Distance d at which the blend leaves the corner exactly `tolerance` aside: its middle lies 3/16 d (d2 - d1) off the
/// corner, and no other point of it is nearer. Norms over the linear axes; infinite where the direction does not
/// change.
double blend_reach(const Limits& limits, const AxisVec& d1, const AxisVec& d2, double tolerance_mm);

/// From corner - d d1 to corner + d d2. Acceleration is continuous at both ends: q'' = 0 there.
Geometry blend(const AxisVec& corner, const AxisVec& d1, const AxisVec& d2, double d);

/// Bounds of s on the blend: within them, in any combination, no axis breaks its limits. Half of the axis acceleration
/// and jerk goes to curvature, the rest is left for speeding up and down.
Bounds blend_bounds(const Limits& limits, const AxisVec& d1, const AxisVec& d2, double d, double v_wanted);

}  // namespace gantry::motion
