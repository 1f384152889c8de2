// q(s) of a segment and its derivatives by s: what the loop, the planner and every judge evaluate alike.
//   Geometry g = straight(from, displacement, length);
//   AxisVec q = point(g, s);   q' = derivative<1>(g, s);   GeometryJet x = jet(g, s);      // all of them at once
// s is clamped to nothing: callers stay within [0, length]. Safe in the loop.
#pragma once
#include <bit>

#include "motion/types.hpp"

namespace gantry::motion {

/// Point and derivatives by s.
struct GeometryJet {
  AxisVec q{}, d1{}, d2{}, d3{};
};

[[nodiscard]] inline Geometry standing(const AxisVec& q, double length) noexcept {
  Geometry g;
  g.length = length;
  g.from = q;
  return g;
}

[[nodiscard]] inline Geometry straight(const AxisVec& from, const AxisVec& displacement, double length) noexcept {
  Geometry g;
  g.length = g.whole = length;
  g.from = from;
  g.degree = 1;
  std::size_t n = 0;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    if (displacement[i] == 0) continue;
    g.moving = static_cast<std::uint16_t>(g.moving | 1u << i);
    g.c[n++] = displacement[i];
  }
  return g;
}

/// u of a part of a curve at s.
[[nodiscard]] inline double parameter(const Geometry& g, double s) noexcept {
  const double x = (g.begin + s) * (1 / g.whole);
  return x * (g.u[0] + x * (g.u[1] + x * (g.u[2] + x * (g.u[3] + x * g.u[4]))));
}

/// Of the k-th axis that moves on a curve, from where u is 0.
[[nodiscard]] inline double displacement(const Geometry& g, std::size_t k, double u) noexcept {
  return u * (g.c[3 * k] + u * (g.c[3 * k + 1] + u * g.c[3 * k + 2]));
}

/// n derivatives (up to 3) into `out`; the others stay as they are.
template <int n>
inline void differentiate(const Geometry& g, double s, GeometryJet& out) noexcept {
  out.q = g.from;
  if (g.degree == 0 || !(g.whole > 0)) return;
  const double per = 1 / g.whole, x = (g.begin + s) * per;
  unsigned moving = g.moving;
  if (g.degree == 1) {
    for (std::size_t k = 0; moving != 0; moving &= moving - 1, ++k) {
      const auto i = static_cast<std::size_t>(std::countr_zero(moving));
      out.q[i] += g.c[k] * x;
      if constexpr (n > 0) out.d1[i] = g.c[k] * per;
    }
    return;
  }
  const auto& a = g.u;
  const double u = parameter(g, s);
  const double u1 = per * (a[0] + x * (2 * a[1] + x * (3 * a[2] + x * (4 * a[3] + x * 5 * a[4]))));
  const double u2 = per * per * (2 * a[1] + x * (6 * a[2] + x * (12 * a[3] + x * 20 * a[4])));
  const double u3 = per * per * per * (6 * a[2] + x * (24 * a[3] + x * 60 * a[4]));
  for (std::size_t k = 0; moving != 0; moving &= moving - 1, ++k) {
    const auto i = static_cast<std::size_t>(std::countr_zero(moving));
    const double c1 = g.c[3 * k], c2 = g.c[3 * k + 1], c3 = g.c[3 * k + 2];
    out.q[i] += displacement(g, k, u);
    if constexpr (n > 0) {
      const double q1 = c1 + u * (2 * c2 + u * 3 * c3), q2 = 2 * c2 + u * 6 * c3, q3 = 6 * c3;
      out.d1[i] = q1 * u1;
      if constexpr (n > 1) out.d2[i] = q2 * u1 * u1 + q1 * u2;
      if constexpr (n > 2) out.d3[i] = q3 * u1 * u1 * u1 + 3 * q2 * u1 * u2 + q1 * u3;
    }
  }
}

[[nodiscard]] inline GeometryJet jet(const Geometry& g, double s) noexcept {
  GeometryJet out;
  differentiate<3>(g, s, out);
  return out;
}

/// n-th derivative of q by s at s (n = 0: the point). A standstill has none.
template <int n>
[[nodiscard]] inline AxisVec derivative(const Geometry& g, double s) noexcept {
  GeometryJet out;
  differentiate<n>(g, s, out);
  if constexpr (n == 0) return out.q;
  if constexpr (n == 1) return out.d1;
  if constexpr (n == 2) return out.d2;
  return out.d3;
}

[[nodiscard]] inline AxisVec point(const Geometry& g, double s) noexcept { return derivative<0>(g, s); }

}  // namespace gantry::motion
