// Which of many boxes does one box meet? A tree of boxes, halved across the longer side of where they stand, so that
// the world's watch looks at the few solids that are near. It is the world's own: the planner's tree is another's code.
//   SolidTree tree(bounds);   tree.meets(swept, found);      // indices, ascending
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "sim/world/obstacles.hpp"

namespace gantry::sim {

class SolidTree {
 public:
  SolidTree() = default;
  explicit SolidTree(std::span<const Bounds> solids);

  /// Every solid whose bounds meet `b`, and no other, in ascending order. `to` is overwritten.
  void meets(const Bounds& b, std::vector<std::uint32_t>& to) const;

 private:
  struct Node {
    Bounds bounds;
    std::uint32_t skip = 0;       ///< the node that follows when this one is left out
    std::uint32_t solid = kMany;  ///< of a leaf
  };
  static constexpr std::uint32_t kMany = ~std::uint32_t{0};
  void build(std::span<const Bounds> solids, std::span<std::uint32_t> inside);
  std::vector<Node> nodes_;  ///< each is followed by all that are below it
};

}  // namespace gantry::sim
