#include "config/upright.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gantry::config {
namespace {

/// How far a turned rectangle reaches from its centre along a direction.
double reach(const Upright& body, Vec2 along) {
  const Vec2 x = rotated({body.half.x, 0}, body.rotation_rad), y = rotated({0, body.half.y}, body.rotation_rad);
  return std::abs(dot(x, along)) + std::abs(dot(y, along));
}

/// Two rectangles are apart where they are so along an edge's normal of either (separating axes).
bool rectangles(const Upright& a, const Upright& b, double slack_mm) {
  const Vec2 between = b.centre - a.centre;
  for (const Upright* of : {&a, &b})
    for (const Vec2 edge : std::array{Vec2{1, 0}, Vec2{0, 1}}) {
      const Vec2 normal = rotated(edge, of->rotation_rad);
      if (std::abs(dot(between, normal)) >= reach(a, normal) + reach(b, normal) - slack_mm) return false;
    }
  return true;
}

/// From a point to a rectangle.
double beside(Vec2 point, const Upright& box) {
  const Vec2 p = rotated(point - box.centre, -box.rotation_rad);
  return norm(Vec2{std::max(0.0, std::abs(p.x) - box.half.x), std::max(0.0, std::abs(p.y) - box.half.y)});
}

bool disc_and_rectangle(const Upright& disc, const Upright& box, double slack_mm) {
  return beside(disc.centre, box) < disc.half.x - slack_mm;
}

/// Two convex figures that are apart are nearest where a corner of one of them is.
double from_corners(const Upright& a, const Upright& b) {
  double least = HUGE_VAL;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      least = std::min(least, beside(a.centre + rotated({x * a.half.x, y * a.half.y}, a.rotation_rad), b));
      least = std::min(least, beside(b.centre + rotated({x * b.half.x, y * b.half.y}, b.rotation_rad), a));
    }
  return least;
}

double seen_from_above(const Upright& a, const Upright& b) {
  if (!a.round && !b.round) return rectangles(a, b, 0) ? 0 : from_corners(a, b);
  if (!a.round || !b.round) {
    const Upright &disc = a.round ? a : b, &box = a.round ? b : a;
    return std::max(0.0, beside(disc.centre, box) - disc.half.x);
  }
  return std::max(0.0, norm(a.centre - b.centre) - a.half.x - b.half.x);
}

}  // namespace

Upright upright(const Body& body) {
  const Vec3 size = body.shape.size;
  return {.centre = flat(body.centre),
          .half = {size.x / 2, size.y / 2},
          .rotation_rad = body.rotation_rad,
          .low = body.centre.z - size.z / 2,
          .high = body.centre.z + size.z / 2,
          .round = body.shape.kind != Shape::Kind::Box};
}

bool in_one_another(const Upright& a, const Upright& b, double slack_mm) {
  if (std::min(a.high, b.high) - std::max(a.low, b.low) <= slack_mm) return false;
  if (a.round && b.round) return norm(a.centre - b.centre) < a.half.x + b.half.x - slack_mm;
  if (a.round) return disc_and_rectangle(a, b, slack_mm);
  return b.round ? disc_and_rectangle(b, a, slack_mm) : rectangles(a, b, slack_mm);
}

double distance_mm(const Body& a, const Body& b) {
  double rounding_mm = 0;
  // A capsule is a line that is thick all around.
  const auto core = [&](const Body& body) {
    Upright u = upright(body);
    if (body.shape.kind != Shape::Kind::Capsule) return u;
    rounding_mm += u.half.x;
    u.low += u.half.x, u.high -= u.half.x;
    u.half = {};
    return u;
  };
  const Upright one = core(a), other = core(b);
  const double up = std::max({0.0, one.low - other.high, other.low - one.high});
  return std::max(0.0, std::hypot(seen_from_above(one, other), up) - rounding_mm);
}

}  // namespace gantry::config
