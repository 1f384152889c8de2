// Where the tool is on a stretch at a time: constant-jerk pieces give s, curves give the axes.
//   PathCursor c;  for (t ...) CurveSetpoint x = c.at(stretch, t, axes);     // t rises: each call goes on from the
//   last
// For benches and tests: the machine plays segments (run.hpp).
#pragma once
#include <cstddef>

#include "motion/path/timing.hpp"

namespace gantry::motion::test {

struct CurveSetpoint {
  AxisVec q{}, v{}, a{};
  double s = 0, s_dot = 0;  ///< in the stretch, and the tool's speed
};

class PathCursor {
 public:
  [[nodiscard]] CurveSetpoint at(const Stretch& stretch, double t, std::size_t axes) noexcept;

 private:
  std::size_t piece_ = 0, curve_ = 0;
  double piece_t_ = 0, curve_s_ = 0;  ///< where they begin
};

inline CurveSetpoint PathCursor::at(const Stretch& stretch, double t, std::size_t axes) noexcept {
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

}  // namespace gantry::motion::test
