#include "motion/plan/tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace gantry::motion {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlack_mm = 1e-6;  // a box is larger than what is in it by more than rounding

struct Bounds {
  Vec3 low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  void take(Vec3 p, Vec3 half) {
    low = {std::min(low.x, p.x - half.x), std::min(low.y, p.y - half.y), std::min(low.z, p.z - half.z)};
    high = {std::max(high.x, p.x + half.x), std::max(high.y, p.y + half.y), std::max(high.z, p.z + half.z)};
  }
};

}  // namespace

Tree::Tree(std::span<const Box> bodies) {
  if (bodies.empty()) return;
  std::vector<std::uint32_t> order(bodies.size());
  std::iota(order.begin(), order.end(), 0U);
  nodes_.reserve(2 * bodies.size() - 1);
  build(bodies, order);
}

/// Halves by the middle body along the axis in which the centres spread most; ties by index, so that a scene always has
/// the same tree.
void Tree::build(std::span<const Box> bodies, std::span<std::uint32_t> part) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  Bounds all, centres;
  for (const std::uint32_t i : part) all.take(bodies[i].centre, bodies[i].half), centres.take(bodies[i].centre, {});
  nodes_[self].box = {(all.low + all.high) * 0.5, (all.high - all.low) * 0.5 + Vec3{kSlack_mm, kSlack_mm, kSlack_mm}};
  if (part.size() == 1) {
    nodes_[self].body = part.front();
  } else {
    const Vec3 spread = centres.high - centres.low;
    double Vec3::*const axis = spread.x >= spread.y && spread.x >= spread.z ? &Vec3::x
                               : spread.y >= spread.z                       ? &Vec3::y
                                                                            : &Vec3::z;
    const std::size_t half = part.size() / 2;
    std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(half), part.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double pa = bodies[a].centre.*axis, pb = bodies[b].centre.*axis;
                       return pa < pb || (pa == pb && a < b);
                     });
    build(bodies, part.first(half));
    build(bodies, part.subspan(half));
  }
  nodes_[self].skip = static_cast<std::uint32_t>(nodes_.size());
}

}  // namespace gantry::motion
