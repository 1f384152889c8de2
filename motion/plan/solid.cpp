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

Solid turned(Solid s, Vec2 about, double angle_rad) {
  const double c = std::cos(angle_rad), sn = std::sin(angle_rad);
  const Vec2 d = flat(s.centre) - about;
  s.centre = {about.x + c * d.x - sn * d.y, about.y + sn * d.x + c * d.y, s.centre.z};
  const double cos = c * s.cos - sn * s.sin;
  s.sin = sn * s.cos + c * s.sin, s.cos = cos;
  return s;
}

double turning_radius(const Solid& s, Vec2 about) {
  const Vec2 d = flat(s.centre) - about;
  if (s.kind != Solid::Kind::Box) return norm(d);
  // In the box's own directions the farthest corner lies away from the line along both.
  const double x = s.cos * d.x + s.sin * d.y, y = s.cos * d.y - s.sin * d.x;
  return std::hypot(std::abs(x) + s.half.x, std::abs(y) + s.half.y);
}

double extent(const Solid& s, Vec3 n) {
  const double up = std::abs(n.z) * s.half.z + (s.disc > 0 ? s.disc * std::hypot(n.x, n.y) : 0.0);
  switch (s.kind) {
    case Solid::Kind::Box:
      return std::abs(n.x * s.cos + n.y * s.sin) * s.half.x + std::abs(n.y * s.cos - n.x * s.sin) * s.half.y + up;
    case Solid::Kind::Cylinder: return std::hypot(n.x, n.y) * s.half.x + up;
    case Solid::Kind::Capsule: break;
  }
  return s.half.x + up;
}

}  // namespace gantry::motion
