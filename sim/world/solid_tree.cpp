#include "sim/world/solid_tree.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace gantry::sim {

SolidTree::SolidTree(std::span<const Bounds> solids) {
  std::vector<std::uint32_t> all(solids.size());
  std::iota(all.begin(), all.end(), 0u);
  nodes_.reserve(2 * solids.size());
  if (!all.empty()) build(solids, all);
}

void SolidTree::build(std::span<const Bounds> solids, std::span<std::uint32_t> inside) {
  const std::size_t self = nodes_.size();
  Bounds all = solids[inside.front()];
  for (const std::uint32_t i : inside) all = joined(all, solids[i]);
  nodes_.push_back({all, 0, inside.size() == 1 ? inside.front() : kMany});
  if (inside.size() > 1) {
    const Vec3 edges = all.high - all.low;
    const std::size_t longest = edges.x >= edges.y && edges.x >= edges.z ? 0 : edges.y >= edges.z ? 1 : 2;
    const auto twice_middle = [&](std::uint32_t i) { return component(solids[i].low + solids[i].high, longest); };
    const std::size_t half = inside.size() / 2;
    std::nth_element(inside.begin(), inside.begin() + static_cast<std::ptrdiff_t>(half), inside.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       return std::pair(twice_middle(a), a) < std::pair(twice_middle(b), b);
                     });
    build(solids, inside.first(half));
    build(solids, inside.subspan(half));
  }
  nodes_[self].skip = static_cast<std::uint32_t>(nodes_.size());
}

void SolidTree::meets(const Bounds& b, std::vector<std::uint32_t>& to) const {
  to.clear();
  for (std::uint32_t i = 0; i < nodes_.size();) {
    const Node& node = nodes_[i];
    const bool near = b.meets(node.bounds);
    if (near && node.solid != kMany) to.push_back(node.solid);
    i = near ? i + 1 : node.skip;
  }
  std::sort(to.begin(), to.end());
}

}  // namespace gantry::sim
