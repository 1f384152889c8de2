#include "motion/path/path_cursor.hpp"

#include <algorithm>

namespace gantry::motion {

CurveSetpoint PathCursor::at(const Stretch& stretch, double t, std::size_t axes) noexcept {
  const auto& pieces = stretch.pieces;
  const auto& curves = stretch.curves;
  while (piece_ + 1 < pieces.size() && t >= piece_t_ + pieces[piece_].duration_s)
    piece_t_ += pieces[piece_++].duration_s;
  const State x = after(pieces[piece_], t - piece_t_);
  while (curve_ + 1 < curves.size() && x.p >= curve_s_ + curves[curve_].length) curve_s_ += curves[curve_++].length;
  const CurveJet g = jet(curves[curve_], x.p - curve_s_, axes);
  CurveSetpoint out;
  out.s = x.p, out.s_dot = x.v;
  for (std::size_t i = 0; i < axes; ++i) {
    out.q[i] = g.q[i];
    out.v[i] = g.d1[i] * x.v;
    out.a[i] = g.d2[i] * x.v * x.v + g.d1[i] * x.a;
  }
  return out;
}

}  // namespace gantry::motion
