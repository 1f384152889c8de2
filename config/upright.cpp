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

bool disc_and_rectangle(const Upright& disc, const Upright& box, double slack_mm) {
  const Vec2 p = rotated(disc.centre - box.centre, -box.rotation_rad);
  const Vec2 beyond{std::max(0.0, std::abs(p.x) - box.half.x), std::max(0.0, std::abs(p.y) - box.half.y)};
  return norm(beyond) < disc.half.x - slack_mm;
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

}  // namespace gantry::config
