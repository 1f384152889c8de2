#include "motion/plan/wide_tree.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

/// Of the largest coordinate: single precision errs by 6e-8 in each of the few operations of a test.
constexpr double kErrs = 3e-6;
constexpr float kNowhere = 1e30F;

Float4 four(double v) {
  const auto f = static_cast<float>(v);
  return Float4{f, f, f, f};
}

}  // namespace

WideQuestion::WideQuestion(Vec3 at, Vec3 reaches, Vec3 half, const std::array<Vec3, 3>& unit, double margin_mm,
                           double largest_mm) {
  const double largest = std::max(
      {largest_mm, std::abs(at.x) + reaches.x, std::abs(at.y) + reaches.y, std::abs(at.z) + reaches.z, margin_mm});
  const double more = margin_mm + kErrs * largest;
  for (std::size_t i = 0; i < 3; ++i) {
    middle[i] = four(component(at, i)), reach[i] = four(component(reaches, i) + more);
    const Vec3 n = unit[i], parts{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    thick[i] = four(dot(parts, half) + more);
    const std::size_t a = i == 0 ? 1 : 0, b = i == 2 ? 1 : 2;
    across[i] = {four(component(n, a)), four(component(n, b))};
    across_parts[i] = {four(component(parts, a)), four(component(parts, b))};
  }
}

WideTree::WideTree(const Tree& tree) {
  for (const Tree::Node& n : tree.nodes())
    largest_ = std::max({largest_, std::abs(n.box.centre.x) + n.box.half.x, std::abs(n.box.centre.y) + n.box.half.y,
                         std::abs(n.box.centre.z) + n.box.half.z});
  if (!tree.nodes().empty()) build(tree, 0);
}

std::uint32_t WideTree::build(const Tree& tree, std::uint32_t node) {
  const auto& nodes = tree.nodes();
  // Up to four: the widest inner ones are opened.
  std::array<std::uint32_t, 4> part{node};
  std::size_t count = 1;
  while (count < 4) {
    std::size_t widest = 4;
    double most = -1;
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 h = nodes[part[i]].box.half;
      const double area = h.x * h.y + h.y * h.z + h.z * h.x;
      if (nodes[part[i]].body == Tree::kInner && area > most) most = area, widest = i;
    }
    if (widest == 4) break;
    const std::uint32_t first = part[widest] + 1;
    part[widest] = first, part[count++] = nodes[first].skip;
  }
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  for (std::size_t k = 0; k < 3; ++k) nodes_[self].centre[k] = four(kNowhere), nodes_[self].half[k] = four(0);
  for (std::size_t i = 0; i < count; ++i) {
    const Tree::Node& from = nodes[part[i]];
    for (std::size_t k = 0; k < 3; ++k) {
      nodes_[self].centre[k][i] = static_cast<float>(component(from.box.centre, k));
      nodes_[self].half[k][i] = static_cast<float>(component(from.box.half, k));
    }
    const std::uint32_t link = from.body == Tree::kInner ? build(tree, part[i]) : kLeaf | from.body;
    nodes_[self].link[i] = link;
  }
  return self;
}

}  // namespace gantry::motion
