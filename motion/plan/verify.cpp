#include "motion/plan/verify.hpp"

#include <cmath>

namespace gantry::motion {
namespace {

constexpr double kRounding = 1e-9;  // mm on a metre, in double precision with room to spare
constexpr double kTouching_mm = 1e-9;

bool within(Vec3 centre, Vec3 half, const Box& box) {
  const Vec3 d = centre - box.centre;
  return std::abs(d.x) + half.x <= box.half.x && std::abs(d.y) + half.y <= box.half.y &&
         std::abs(d.z) + half.z <= box.half.z;
}

double half_along(const Box& box, Vec3 n) {
  return std::abs(n.x) * box.half.x + std::abs(n.y) * box.half.y + std::abs(n.z) * box.half.z;
}

/// Walks the tree for one body of the head; each separation must be of the node at which the walk stands.
class Walk {
 public:
  Walk(const Scene& scene, const AxisVec& from, const AxisVec& to, std::span<const Separation> proof,
       const Margins& margins)
      : scene_(scene), from_(from), to_(to), proof_(proof), margins_(margins) {}

  bool all() {
    const auto& nodes = scene_.tree().nodes();
    for (std::size_t head = 0; head < scene_.head().size(); ++head)
      for (std::size_t node = 0; node < nodes.size();) {
        const bool named = next_ < proof_.size() && proof_[next_].head == head && proof_[next_].node == node;
        if (!named && nodes[node].body != Tree::kInner) return false;  // a body that nothing parts off
        if (named && !parted(head, nodes[node])) return false;
        node = named ? nodes[node].skip : node + 1;
      }
    return next_ == proof_.size();
  }

 private:
  bool parted(std::size_t head, const Tree::Node& node) {
    const double margin = node.body == Tree::kInner ? margins_.clearance_mm : margins_.of(head, node.body);
    return holds(scene_, from_, to_, proof_[next_++], margin);
  }

  const Scene& scene_;
  const AxisVec &from_, &to_;
  std::span<const Separation> proof_;
  const Margins& margins_;
  std::size_t next_ = 0;
};

}  // namespace

bool holds_all(const Tree& tree, std::span<const SceneBody> standing) {
  const auto& nodes = tree.nodes();
  std::vector<bool> seen(standing.size(), false);
  std::vector<std::size_t> above;  // inner nodes that are open
  std::size_t bodies = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Tree::Node& node = nodes[i];
    while (!above.empty() && i >= nodes[above.back()].skip) above.pop_back();
    if (i > 0 && above.empty()) return false;
    const bool leaf = node.body != Tree::kInner;
    if (node.skip <= i || node.skip > nodes.size() || (leaf && node.skip != i + 1)) return false;
    if (!above.empty() &&
        (node.skip > nodes[above.back()].skip ||
         !within(node.box.centre, node.box.half - Vec3{kRounding, kRounding, kRounding}, nodes[above.back()].box)))
      return false;
    if (!leaf) {
      above.push_back(i);
      continue;
    }
    if (node.body >= standing.size() || seen[node.body]) return false;
    seen[node.body] = true;
    ++bodies;
  }
  if (bodies != standing.size()) return false;
  // Each body within each box above it: boxes within boxes alone would add their rounding up.
  above.clear();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    while (!above.empty() && i >= nodes[above.back()].skip) above.pop_back();
    above.push_back(i);
    if (nodes[i].body == Tree::kInner) continue;
    const Solid& s = standing[nodes[i].body].solid;
    const Vec3 half{extent(s, {1, 0, 0}), extent(s, {0, 1, 0}), extent(s, {0, 0, 1})};
    for (const std::size_t box : above)
      if (!within(s.centre, half, nodes[box].box)) return false;
  }
  return true;
}

bool holds(const Scene& scene, const AxisVec& from, const AxisVec& to, const Separation& separation, double margin_mm) {
  const Vec3 n = separation.direction;
  if (!(std::abs(dot(n, n) - 1) < kRounding)) return false;
  const SceneBody& a = scene.head()[separation.head];
  const Tree::Node& node = scene.tree().nodes()[separation.node];
  // Furthest of the moving body along n is at one of the two ends of its motion; both are looked at.
  const double reach = extent(a.solid, n);
  const double at_from = dot(n, a.solid.centre + scene.carried(a, from)) + reach;
  const double at_to = dot(n, a.solid.centre + scene.carried(a, to)) + reach;
  double begins = 0;
  if (node.body == Tree::kInner) {
    begins = dot(n, node.box.centre) - half_along(node.box, n);
  } else {
    const Solid& b = scene.standing()[node.body].solid;
    begins = dot(n, b.centre) - extent(b, n);
  }
  return begins - at_from >= margin_mm + kTouching_mm && begins - at_to >= margin_mm + kTouching_mm;
}

bool is_free(const Scene& scene, const AxisVec& from, const AxisVec& to, std::span<const Separation> proof,
             const Margins& margins) {
  return scene.tree_holds() && Walk(scene, from, to, proof, margins).all();
}

}  // namespace gantry::motion
