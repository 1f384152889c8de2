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

Vec3 core_support(const Solid& s, Vec3 d) {
  switch (s.kind) {
    case Solid::Kind::Box: {
      const double x = std::copysign(s.half.x, s.cos * d.x + s.sin * d.y);
      const double y = std::copysign(s.half.y, s.cos * d.y - s.sin * d.x);
      return s.centre + Vec3{s.cos * x - s.sin * y, s.sin * x + s.cos * y, std::copysign(s.half.z, d.z)};
    }
    case Solid::Kind::Cylinder: {
      const double flat = std::sqrt(d.x * d.x + d.y * d.y), k = flat > 0 ? s.half.x / flat : 0.0;
      return s.centre + Vec3{k * d.x, k * d.y, std::copysign(s.half.z, d.z)};
    }
    case Solid::Kind::Capsule: break;
  }
  return s.centre + Vec3{0, 0, std::copysign(s.half.z, d.z)};
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
