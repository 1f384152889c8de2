// A piece of the tool's path: a cubic in u for each axis, and u as a function of arc length, so that s is the length
// that the tool travels.
//   append_curve(measure, bezier_points, cells, out);     // one piece, or several where one would not carry arc length
//   CurveJet x = jet(piece, s, axes);                     // q and its first three derivatives by s
// At the joints of a path q, q' and q'' are continuous in s; q''' may jump. Plain values, jet() may run in the loop.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "motion/geometry.hpp"

namespace gantry::motion {

/// How lengths are measured: path length counts the linear axes (the others where no linear axis moves); tolerances
/// count all of them, a rotary axis by `weight` (mm for a rad).
struct Measure {
  std::size_t axes = 0;
  std::array<bool, kMaxAxes> along{};
  std::array<double, kMaxAxes> weight{};
};

struct Curve {
  double length = 0;           ///< mm along the path
  std::array<AxisVec, 4> c{};  ///< q = c0 + c1 u + c2 u^2 + c3 u^3; u begins at 0, and ends at 1 where it is whole
  std::array<double, 6> u{};   ///< u = sum u[k] x^k, x = s / length
  std::uint16_t cells = 1;     ///< speed planning divides it at least into so many parts
  bool straight = false;       ///< c2 = c3 = 0, u = s / length
  bool rest_after = false;     ///< the tool has to stand at its end
};

using CurveJet = GeometryJet;

/// s in [0, length] of the piece; only the first `axes` axes are written.
[[nodiscard]] CurveJet jet(const Curve& curve, double s, std::size_t axes) noexcept;

/// Path length of a displacement.
[[nodiscard]] double along(const Measure& m, const AxisVec& displacement) noexcept;
/// Weighted norm over all axes, for tolerances.
[[nodiscard]] double aside(const Measure& m, const AxisVec& displacement) noexcept;

[[nodiscard]] Curve straight_curve(const Measure& m, const AxisVec& from, const AxisVec& to) noexcept;

/// Of curves one after the other.
[[nodiscard]] double length_of(std::span<const Curve> curves) noexcept;

/// The part of a curve between two lengths along it: the same points, with s from 0. `rest_after` is the whole curve's.
[[nodiscard]] Curve part_of(const Curve& curve, double from, double to) noexcept;

/// The cubic with these four Bezier points, as pieces whose s is arc length to 2e-4: halved until it is, 14 times at
/// most.
void append_curve(const Measure& m, const std::array<AxisVec, 4>& bezier, std::uint16_t cells, std::vector<Curve>& out);

}  // namespace gantry::motion
