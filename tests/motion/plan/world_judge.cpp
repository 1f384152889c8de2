#include "tests/motion/plan/world_judge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/world/collisions.hpp"

namespace gantry::test {
namespace {

using Kind = config::Shape::Kind;
constexpr double kMillisecond_mm = 0.2;
constexpr double kSlack_mm = 1e-5;  // contact of what is larger may be told a hair too early

/// Within the body and a ball of `by` about it: a capsule has just that radius more, of others a corner goes that far.
config::Shape larger(config::Shape s, double by) {
  const double all = 2 * (s.kind == Kind::Capsule ? by : by / std::numbers::sqrt3);
  s.size = s.size + Vec3{all, all, all};
  return s;
}

}  // namespace

Stands leaning(const config::Body& box, Vec2 slope) {
  Stands out = upright(box);
  out.truly.slope = slope;
  // The world's box has its X along (1, 0, slope.x) and its Z across both slopes.
  const auto unit = [](Vec3 v) { return v * (1 / norm(v)); };
  const Vec3 x = unit({1, 0, slope.x}), z = unit({-slope.x, -slope.y, 1}), y = cross(z, x), s = box.shape.size;
  out.told.shape.size = {std::abs(x.x) * s.x + std::abs(y.x) * s.y + std::abs(z.x) * s.z,
                         std::abs(x.y) * s.x + std::abs(y.y) * s.y + std::abs(z.y) * s.z,
                         std::abs(x.z) * s.x + std::abs(y.z) * s.y + std::abs(z.z) * s.z};
  return out;
}

WorldJudge::WorldJudge(const config::Machine& machine, std::vector<sim::Solid> truly)
    : machine_(machine), truly_(std::move(truly)) {
  const double by = std::max(0.0, machine.clearance_mm - kSlack_mm);
  for (config::Body& b : machine_.head) b.shape = larger(b.shape, by);
}

bool WorldJudge::collides(std::span<const AxisVec> path) const {
  const sim::Head head(machine_);
  sim::CollisionWatch watch(head);
  watch.set_solids(truly_);
  bool collided = !path.empty() && !watch.step(path[0], path[0], 0.001).empty();
  for (std::size_t i = 0; i + 1 < path.size() && !collided; ++i) {
    const AxisVec &a = path[i], &b = path[i + 1];
    const double length = norm(Vec3{b[0] - a[0], b[1] - a[1], b[2] - a[2]});
    const int steps = 1 + static_cast<int>(length / kMillisecond_mm);
    for (int k = 0; k < steps && !collided; ++k)
      collided = !watch.step(between(a, b, 1.0 * k / steps), between(a, b, (k + 1.0) / steps), 0.001).empty();
  }
  return collided;
}

}  // namespace gantry::test
