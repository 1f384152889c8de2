// From geometry with bounds to geometry with time: speeds at the boundaries of a chain of pieces, and each piece's
// s(t).
//   std::vector<double> v = boundary_speeds(pieces);       // n + 1 values
//   Profile p = piece_profile(pieces[k], v[k], v[k + 1]);
// The acceleration along the path is 0 at every boundary.
#pragma once
#include <cmath>
#include <span>
#include <vector>

#include "motion/profile/planner.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

struct Piece {
  Geometry geometry;
  Bounds bounds;            ///< of the derivatives of s, from the axis limits
  double v_wanted = 0;      ///< speed along s that is asked for
  bool stop_after = false;  ///< rest at its end
};

/// Bounds of s on a straight line with q' = direction.
Bounds line_bounds(const Limits& limits, const AxisVec& direction);

/// Highest speeds at the boundaries by a backward and a forward pass. `v_first` and `v_last` cap the ends.
std::vector<double> boundary_speeds(std::span<const Piece> pieces, double v_first, double v_last);

/// Shortest s(t) over a piece between two boundary speeds that boundary_speeds allows.
Profile piece_profile(const Piece& piece, double v_in, double v_out);

/// A profile as a segment carries it.
SpeedProfile nominal(const Profile& profile);

/// Duration rounded up to whole ticks; what is within rounding of a tick is that tick.
inline double whole_ticks(double seconds, double tick_s) { return std::ceil(seconds / tick_s - 1e-9) * tick_s; }

}  // namespace gantry::motion
