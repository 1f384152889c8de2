// Bodies that stand upright: whether two of them are in one another, seen from above and in height, and how far apart.
//   if (in_one_another(upright(a), upright(b), 0.1)) ...
#pragma once
#include "config/machine.hpp"
#include "core/vec.hpp"

namespace gantry::config {

struct Upright {
  Vec2 centre, half;        ///< mm; before it is turned
  double rotation_rad = 0;  ///< about its centre
  double low = 0, high = 0;
  bool round = false;  ///< of radius half.x
};

/// Of a body, in the frame in which its centre is given.
Upright upright(const config::Body& body);

/// Whether they share more than `slack_mm` in every direction.
bool in_one_another(const Upright& a, const Upright& b, double slack_mm);

/// Between their surfaces, mm, a capsule's round ends as they are; 0 where they touch or are in one another.
double distance_mm(const Body& a, const Body& b);

}  // namespace gantry::config
