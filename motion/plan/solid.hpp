// Convex bodies as collision checking sees them, in mm. Cylinders and capsules stand along Z; a box may be turned about
// Z.
//   Solid s = make_solid(body);   // body: config::Body of the machine file
// A solid is a core and a rounding about it (a capsule: its axis and its radius), so that round things stay exact.
// Extents are what the second check (verify.hpp) uses; the first makes a body of its own of each pair (difference.hpp).
#pragma once
#include <cstdint>

#include "config/machine.hpp"
#include "core/vec.hpp"

namespace gantry::motion {

struct Solid {
  enum class Kind : std::uint8_t { Box, Cylinder, Capsule } kind = Kind::Box;
  Vec3 centre;
  Vec3 half;  ///< box: half edges; cylinder: {radius, radius, half height}; capsule: half length of its axis in z
  double cos = 1, sin = 0;  ///< of the box's turn
  double disc = 0;          ///< it reaches farther by this in the plane, all around: what is left open of how it turns
};

Solid make_solid(const config::Body& body);

inline Solid moved(Solid solid, Vec3 by) {
  solid.centre = solid.centre + by;
  return solid;
}

/// Turned about an upright line, counter-clockwise as seen from above.
Solid turned(Solid solid, Vec2 about, double angle_rad);
/// How far its farthest point is from an upright line, counted as what turning moves: a round body is itself again when
/// it is turned about its own middle.
double turning_radius(const Solid& solid, Vec2 about);

/// How far the solid reaches from its centre along the unit vector `n`: all shapes are symmetric about their centre.
double extent(const Solid& solid, Vec3 n);
/// Half edges of its axis-aligned box.
inline Vec3 half_box(const Solid& s) { return {extent(s, {1, 0, 0}), extent(s, {0, 1, 0}), extent(s, {0, 0, 1})}; }

}  // namespace gantry::motion
