// Points on curves, as a bead needs them: chords that stay within `sag_mm` of the curve, turn by at most 15 degrees
// from one to the next, and are never much shorter than their neighbours.
//   auto arc = arc_through(from, through, to);                   // Result<Arc>
//   auto curve = sample(*arc, sag_mm, most_points);              // Result<Curve>, first and last point exact
// Pure. mm and rad; z is carried along, so that an arc through three points may stand or lean.
#pragma once
#include <cstddef>
#include <vector>

#include "core/error.hpp"
#include "core/vec.hpp"

namespace gantry::recipes {

/// Chords are off their curve by at most this part of how far the bead may leave it.
inline constexpr double kSagOfTolerance = 1.0 / 20;

/// The point at angle t, 0 .. |angle_rad|: centre + cos t * ahead + sin t * aside.
struct Arc {
  Vec3 centre, ahead, aside;  ///< ahead: from the centre to where it starts; aside: a quarter turn on
  double angle_rad = 0;       ///< > 0, at most a full turn
  Vec3 from, to;              ///< its ends, exactly as they were given
};
/// Fault::Inconsistent: two points coincide, or all lie on one line (to a micrometre).
Result<Arc> arc_through(Vec3 from, Vec3 through, Vec3 to);
/// Level, counter-clockwise where the angle is above 0. Fault::Inconsistent: no radius, no angle.
Result<Arc> arc_about(Vec2 centre, Vec3 from, double angle_rad);

/// r = from_radius + pitch * turns, level at centre.z.
struct Spiral {
  Vec3 centre;
  double from_radius_mm = 0, to_radius_mm = 0;
  double pitch_mm = 0;  ///< > 0: radius gained or lost in a turn
  double start_rad = 0;
  bool clockwise = false;
};

struct Curve {
  std::vector<Vec3> points;
  double length_mm = 0;  ///< of the curve, not of its chords
};
/// Fault::TooManySteps where more than `most` points would be needed.
Result<Curve> sample(const Arc& arc, double sag_mm, std::size_t most);
Result<Curve> sample(const Spiral& spiral, double sag_mm, std::size_t most);

}  // namespace gantry::recipes
