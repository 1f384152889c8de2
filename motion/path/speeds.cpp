#include "motion/path/speeds.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace gantry::motion {
namespace {

// The passes leave this part of a piece unused, so that the profile between two extreme speeds exists beyond rounding.
constexpr double kFit = 1 - 1e-9;

double v_limit(const Piece& piece) { return std::min(piece.v_wanted, piece.bounds.v); }

double reach(double v, const Piece& piece) {
  return speed_over_length(v, piece.geometry.length * kFit, {v_limit(piece), piece.bounds.a, piece.bounds.j});
}

}  // namespace

Bounds line_bounds(const Limits& limits, const AxisVec& direction) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Bounds b{kNone, kNone, kNone};
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const double d = std::abs(direction[i]);
    if (d < 1e-12) continue;
    b.v = std::min(b.v, limits.axis[i].v_max / d);
    b.a = std::min(b.a, limits.axis[i].a_max / d);
    b.j = std::min(b.j, limits.axis[i].j_max / d);
  }
  return b;
}

std::vector<double> boundary_speeds(std::span<const Piece> pieces, double v_first, double v_last) {
  std::vector<double> v(pieces.size() + 1, std::numeric_limits<double>::infinity());
  v.front() = v_first;
  v.back() = v_last;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    v[k] = std::min(v[k], v_limit(pieces[k]));
    v[k + 1] = pieces[k].stop_after ? 0 : std::min(v[k + 1], v_limit(pieces[k]));
  }
  for (std::size_t k = pieces.size(); k-- > 0;) v[k] = std::min(v[k], reach(v[k + 1], pieces[k]));
  for (std::size_t k = 0; k < pieces.size(); ++k) v[k + 1] = std::min(v[k + 1], reach(v[k], pieces[k]));
  return v;
}

Profile piece_profile(const Piece& piece, double v_in, double v_out) {
  const Plan plan =
      move({0, v_in, 0}, {piece.geometry.length, v_out, 0}, {v_limit(piece), piece.bounds.a, piece.bounds.j});
  assert(plan);
  return plan.profile;
}

SpeedProfile nominal(const Profile& profile) { return {profile.from.v, profile.from.a, profile.phases}; }

}  // namespace gantry::motion
