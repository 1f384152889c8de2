// Where a moving body may not be carried, as one body: all displacements that let it meet a standing one (the Minkowski
// difference of the two). All bodies stand upright, so that it is a figure of the plane times an interval of Z,
// rounded, and the distance of a displacement from it has a closed form.
//   Difference d = difference(needle, part);   away(d, {40, 0, 0}).distance;   // of the two, once the needle is there
#pragma once
#include <array>

#include "motion/plan/solid.hpp"

namespace gantry::motion {

struct Difference {
  Vec3 centre;  ///< the displacement that brings both centres together
  /// The figure: a point, a rectangle turned by (cos, sin), or eight corners, counter-clockwise about the centre.
  Vec2 half;
  double cos = 1, sin = 0;
  bool eight = false;
  std::array<Vec2, 8> corner{};
  std::array<Vec2, 4> generator{};  ///< the figure is the sum of these segments (-g .. g)
  double disc = 0;                  ///< radius about the figure, in the plane
  double half_height = 0;
  double ball = 0;  ///< radius about all of it
};

Difference difference(const Solid& moving, const Solid& standing);
/// As it is in axes that are turned so that X lies along `x` (unit) and Z stays.
Difference in_axes_along(const Difference& d, Vec2 x);

/// From a displacement to the nearest point of the difference without its rounding `ball`.
struct Away {
  double flat = 0;      ///< distance in the plane, from figure and disc; 0 inside
  double up = 0;        ///< distance along Z; 0 inside
  double distance = 0;  ///< of the bodies; -ball where they overlap beyond their rounding
  Vec3 direction;       ///< unit, from the moving body to the standing one; 0 where there is none
  Vec2 towards{1, 0};   ///< unit, to the figure in the plane, where flat > 0
};
Away away(const Difference& d, Vec3 displacement);

/// Distance in the plane from a point (about the centre) to the figure, without disc.
double flat_distance(const Difference& d, Vec2 at);

/// How far the difference reaches from its centre along `n`: what stands for both bodies in a separating plane.
double reach(const Difference& d, Vec3 n);

}  // namespace gantry::motion
