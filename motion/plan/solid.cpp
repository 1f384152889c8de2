#include "motion/plan/solid.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {

Solid make_solid(const config::Body& body) {
  Solid s;
  s.centre = body.centre;
  s.half = body.shape.size * 0.5;
  switch (body.shape.kind) {
    case config::Shape::Kind::Box:
      s.kind = Solid::Kind::Box;
      s.cos = std::cos(body.rotation_rad), s.sin = std::sin(body.rotation_rad);
      break;
    case config::Shape::Kind::Cylinder: s.kind = Solid::Kind::Cylinder; break;
    case config::Shape::Kind::Capsule:
      s.kind = Solid::Kind::Capsule;
      s.half.z = std::max(0.0, s.half.z - s.half.x);
      break;
  }
  return s;
}

double extent(const Solid& s, Vec3 n) {
  const double up = std::abs(n.z) * s.half.z;
  switch (s.kind) {
    case Solid::Kind::Box:
      return std::abs(n.x * s.cos + n.y * s.sin) * s.half.x + std::abs(n.y * s.cos - n.x * s.sin) * s.half.y + up;
    case Solid::Kind::Cylinder: return std::hypot(n.x, n.y) * s.half.x + up;
    case Solid::Kind::Capsule: break;
  }
  return s.half.x + up;
}

}  // namespace gantry::motion
