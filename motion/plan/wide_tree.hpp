// The tree of boxes (tree.hpp) for quick looks: four boxes a node, in single precision, tested at once. It may name a
// body that is far away, never leave out one that is near: its boxes and the question are larger than the true ones by
// more than single precision errs. Proofs do not rest on it.
//   tree.visit(WideQuestion(...), [&](std::uint32_t body) { return go_on; });
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "motion/plan/tree.hpp"

namespace gantry::motion {

using Float4 = float __attribute__((vector_size(16)));
using Mask4 = std::int32_t __attribute__((vector_size(16)));

/// A box with half edges `half`, swept: its middle, how far it reaches along the axes, and three unit directions across
/// the motion and X, Y, Z each (or 0). `margin_mm` > 0.
struct WideQuestion {
  WideQuestion(Vec3 middle, Vec3 reach, Vec3 half, const std::array<Vec3, 3>& across, double margin_mm,
               double largest_mm);
  std::array<Float4, 3> middle, reach;  ///< reach: with margin
  /// Across X: its y and z; across Y: x and z; across Z: x and y. Then the same without sign.
  std::array<std::array<Float4, 2>, 3> across, across_parts;
  std::array<Float4, 3> thick;  ///< of the box across the motion, with margin
};

class WideTree {
 public:
  WideTree() = default;
  explicit WideTree(const Tree& tree);
  /// The largest coordinate of any box: what single precision errs by depends on it.
  [[nodiscard]] double largest_mm() const { return largest_; }

  /// Calls `leaf(body)` for bodies that may be near, until it says false.
  template <class Leaf>
  void visit(const WideQuestion& question, const Leaf& leaf) const {
    std::array<std::uint32_t, 3 * kDeepest> open;  // NOLINT: filled before it is read
    std::size_t count = 0;
    if (!nodes_.empty()) open[count++] = 0;
    while (count > 0) {
      const Node& node = nodes_[open[--count]];
      const Mask4 far = far_from(node, question);
      for (std::size_t i = 0; i < 4; ++i) {
        if (far[i] != 0) continue;
        if ((node.link[i] & kLeaf) == 0)
          open[count++] = node.link[i];
        else if (!leaf(node.link[i] & ~kLeaf))
          return;
      }
    }
  }

 private:
  static constexpr std::uint32_t kLeaf = 0x80000000U;
  static constexpr std::size_t kDeepest = 40;  ///< the tree halves its bodies: 2^32 of them are 32 deep
  struct Node {
    std::array<Float4, 3> centre, half;
    std::array<std::uint32_t, 4> link{};
  };
  static Float4 size_of(Float4 v) { return reinterpret_cast<Float4>(reinterpret_cast<Mask4>(v) & 0x7fffffff); }
  static Mask4 far_from(const Node& n, const WideQuestion& q) {
    const std::array<Float4, 3> d{n.centre[0] - q.middle[0], n.centre[1] - q.middle[1], n.centre[2] - q.middle[2]};
    Mask4 far = size_of(d[2]) - n.half[2] > q.reach[2];
    far |= size_of(d[0]) - n.half[0] > q.reach[0];
    far |= size_of(d[1]) - n.half[1] > q.reach[1];
    constexpr std::array<std::array<std::size_t, 2>, 3> kOthers{{{1, 2}, {0, 2}, {0, 1}}};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = kOthers[i];
      far |= size_of(q.across[i][0] * d[a] + q.across[i][1] * d[b]) - q.across_parts[i][0] * n.half[a] -
                 q.across_parts[i][1] * n.half[b] >
             q.thick[i];
    }
    return far;
  }
  std::uint32_t build(const Tree& tree, std::uint32_t node);

  std::vector<Node> nodes_;
  double largest_ = 0;
};

}  // namespace gantry::motion
