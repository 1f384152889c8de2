#include "sim/world/obstacles.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::sim {

Bounds bounds_of(const config::Shape& shape, Vec3 centre, double rotation_rad, Vec2 slope) {
  Vec3 half = shape.size * 0.5;
  if (shape.kind == config::Shape::Kind::Box) {
    const double c = std::abs(std::cos(rotation_rad)), s = std::abs(std::sin(rotation_rad));
    // A tilt leans the box over by slope * height and lifts its ends by slope * length.
    const Vec2 leant{half.x + std::abs(slope.x) * half.z, half.y + std::abs(slope.y) * half.z};
    const double lifted = half.z + std::abs(slope.x) * half.x + std::abs(slope.y) * half.y;
    half = {c * leant.x + s * leant.y, s * leant.x + c * leant.y, lifted};
  }
  return {centre - half, centre + half};
}

Bounds joined(const Bounds& a, const Bounds& b) {
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y), std::min(a.low.z, b.low.z)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y), std::max(a.high.z, b.high.z)}};
}

std::vector<Solid> solids_of(std::span<const config::Body> scene, const BoardTruth* board) {
  std::vector<Solid> out;
  for (const config::Body& body : scene) out.push_back({body.name, body.shape, body.centre, body.rotation_rad, {}});
  if (board == nullptr) return out;
  const recipes::Board& cad = board->plan.board;
  out.push_back({"board",
                 {config::Shape::Kind::Box, {cad.size.x, cad.size.y, cad.thickness}},
                 board->to_machine(cad.size * 0.5, -cad.thickness / 2),
                 board->rotation(),
                 board->placement().slope});
  for (const recipes::Part& part : board->plan.parts) {
    // A part stands on the true top face, a fixture on the pallet or over it.
    const Vec3 centre = part.fixture
                            ? board->nominal_to_machine(part.at, part.underside + part.size.z / 2 - cad.thickness)
                            : board->to_machine(part.at, part.size.z / 2);
    const double turn = part.rotation + (part.fixture ? 0.0 : board->rotation());
    out.push_back({part.name, {config::Shape::Kind::Box, part.size}, centre, turn, {}});
  }
  return out;
}

std::optional<Heights> heights_at(const Solid& solid, Vec2 at) noexcept {
  const Vec2 d = at - Vec2{solid.centre.x, solid.centre.y};
  const Vec3& size = solid.shape.size;
  const auto about = [](double middle, double half) { return Heights{middle - half, middle + half}; };
  switch (solid.shape.kind) {
    case config::Shape::Kind::Box: {
      const Vec2 own = rotated(d, -solid.rotation_rad);
      if (std::abs(own.x) > size.x / 2 || std::abs(own.y) > size.y / 2) return std::nullopt;
      return about(solid.centre.z + dot(solid.slope, own), size.z / 2);
    }
    case config::Shape::Kind::Cylinder:
      if (norm(d) > size.x / 2) return std::nullopt;
      return about(solid.centre.z, size.z / 2);
    case config::Shape::Kind::Capsule: {
      const double r = size.x / 2;
      if (norm(d) > r) return std::nullopt;
      return about(solid.centre.z, size.z / 2 - r + std::sqrt(r * r - dot(d, d)));
    }
  }
  return std::nullopt;
}

}  // namespace gantry::sim
