// Everything solid that does not move with the head: the machine's scene, the board with its parts where they truly
// are, and what a script has put in the way.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/vec.hpp"
#include "sim/world/board.hpp"

namespace gantry::sim {

/// A convex body in the machine frame. `slope`: tilt of its own X and Y axes against the horizontal (the board's slab).
struct Solid {
  std::string name;
  config::Shape shape;
  Vec3 centre;
  double rotation_rad = 0;
  Vec2 slope;
};

/// Axis-aligned bounds in mm.
struct Bounds {
  Vec3 low, high;
  [[nodiscard]] bool meets(const Bounds& o) const noexcept {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y && low.z <= o.high.z &&
           o.low.z <= high.z;
  }
};
/// Bounds about a shape's centre when it is turned and tilted.
Bounds bounds_of(const config::Shape& shape, Vec3 centre, double rotation_rad, Vec2 slope);
/// Both and everything between: what a translation from one to the other sweeps.
Bounds joined(const Bounds& a, const Bounds& b);

/// The solids of a scene; `board` may be null (no board lies there).
std::vector<Solid> solids_of(std::span<const config::Body> scene, const BoardTruth* board);

/// A solid's lowest and highest height at (x, y); none where it is not.
struct Heights {
  double low = 0, high = 0;
};
std::optional<Heights> heights_at(const Solid& solid, Vec2 at) noexcept;

}  // namespace gantry::sim
