// Judge of the collision checks: every body stands upright, so it is a figure of the plane (rectangle, disc or point)
// times an interval of Z, and distances have a closed form: flat distance and height gap, at right angles. A capsule is
// such a body (its axis) with a radius. Nothing here is shared with the code that is judged.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "config/machine.hpp"

namespace gantry::test {

using config::Body;
using Kind = config::Shape::Kind;

inline std::array<Vec2, 4> corners(const Body& b) {
  std::array<Vec2, 4> out;
  for (std::size_t i = 0; i < 4; ++i) {
    const double sx = i == 0 || i == 3 ? -1 : 1, sy = i < 2 ? -1 : 1;
    out[i] = rotated({sx * b.shape.size.x / 2, sy * b.shape.size.y / 2}, b.rotation_rad) + Vec2{b.centre.x, b.centre.y};
  }
  return out;
}
inline double point_to_segment(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 d = b - a;
  const double l = dot(d, d), t = l > 0 ? std::clamp(dot(p - a, d) / l, 0.0, 1.0) : 0.0;
  return norm(p - (a + d * t));
}
inline double point_to_box(Vec2 p, const Body& box) {
  const Vec2 q = rotated(p - Vec2{box.centre.x, box.centre.y}, -box.rotation_rad);
  return norm(
      Vec2{std::max(0.0, std::abs(q.x) - box.shape.size.x / 2), std::max(0.0, std::abs(q.y) - box.shape.size.y / 2)});
}
/// Rectangles are apart when the axes of one of them part them (separating axes in the plane); then the nearest points
/// are a corner and a side.
inline double box_to_box(const Body& a, const Body& b) {
  const auto pa = corners(a), pb = corners(b);
  bool apart = false;
  for (const double angle : {a.rotation_rad, b.rotation_rad})
    for (const Vec2 n : {rotated({1, 0}, angle), rotated({0, 1}, angle)}) {
      double a_low = 1e9, a_high = -1e9, b_low = 1e9, b_high = -1e9;
      for (const Vec2 p : pa) a_low = std::min(a_low, dot(n, p)), a_high = std::max(a_high, dot(n, p));
      for (const Vec2 p : pb) b_low = std::min(b_low, dot(n, p)), b_high = std::max(b_high, dot(n, p));
      apart = apart || a_low > b_high || b_low > a_high;
    }
  if (!apart) return 0;
  double best = 1e9;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      best = std::min(best, point_to_segment(pa[i], pb[k], pb[(k + 1) % 4]));
      best = std::min(best, point_to_segment(pb[i], pa[k], pa[(k + 1) % 4]));
    }
  return best;
}

/// Distance of two standing bodies; <= 0 when they touch or overlap.
inline double distance(const Body& a, const Body& b) {
  const bool box_a = a.shape.kind == Kind::Box, box_b = b.shape.kind == Kind::Box;
  const auto disc = [](const Body& x) { return x.shape.kind == Kind::Cylinder ? x.shape.size.x / 2 : 0.0; };
  const Vec2 ca{a.centre.x, a.centre.y}, cb{b.centre.x, b.centre.y};
  const double flat = box_a && box_b ? box_to_box(a, b)
                      : box_a        ? std::max(0.0, point_to_box(cb, a) - disc(b))
                      : box_b        ? std::max(0.0, point_to_box(ca, b) - disc(a))
                                     : std::max(0.0, norm(ca - cb) - disc(a) - disc(b));
  const auto radius = [](const Body& x) { return x.shape.kind == Kind::Capsule ? x.shape.size.x / 2 : 0.0; };
  const auto half = [&](const Body& x) { return std::max(0.0, x.shape.size.z / 2 - radius(x)); };
  const double up = std::max(0.0, std::abs(a.centre.z - b.centre.z) - half(a) - half(b));
  return std::hypot(flat, up) - radius(a) - radius(b);
}

/// Least distance while `a` moves by `d`: convex in the share of `d`, so golden sections end at it.
inline double swept_distance(Body a, Vec3 d, const Body& b) {
  const Vec3 start = a.centre;
  const auto at = [&](double t) {
    a.centre = start + d * t;
    return distance(a, b);
  };
  constexpr double kGolden = 0.6180339887498949;
  double low = 0, high = 1;
  double best = std::min(at(0), at(1));
  for (int i = 0; i <= 64; ++i) best = std::min(best, at(i / 64.0));  // plateaus of a convex function are at its bottom
  for (int i = 0; i < 90; ++i) {
    const double p = high - kGolden * (high - low), q = low + kGolden * (high - low);
    const double fp = at(p), fq = at(q);
    best = std::min({best, fp, fq});
    (fp < fq ? high : low) = fp < fq ? q : p;
  }
  return best;
}

}  // namespace gantry::test
