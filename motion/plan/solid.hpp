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
};

Solid make_solid(const config::Body& body);

inline Solid moved(Solid solid, Vec3 by) {
  solid.centre = solid.centre + by;
  return solid;
}

/// How far the solid reaches from its centre along the unit vector `n`: all shapes are symmetric about their centre.
double extent(const Solid& solid, Vec3 n);

}  // namespace gantry::motion
