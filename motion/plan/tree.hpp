// A tree of boxes over the bodies that stand: what keeps clear of a box keeps clear of all in it.
//   Tree tree(bodies);
//   for (std::size_t i = 0; i < tree.nodes().size();) i = clear_of(tree.nodes()[i].box) ? tree.nodes()[i].skip : i + 1;
// Nodes stand in the order of a walk: a node's subtree is what follows it up to `skip`. A leaf is one body.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.hpp"

namespace gantry::motion {

/// Axis-aligned.
struct Box {
  Vec3 centre, half;
};

class Tree {
 public:
  static constexpr std::uint32_t kInner = 0xffffffffU;
  struct Node {
    Box box;
    std::uint32_t skip = 0;       ///< index of the first node behind the subtree
    std::uint32_t body = kInner;  ///< of a leaf
  };

  Tree() = default;
  explicit Tree(std::span<const Box> bodies);
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

 private:
  void build(std::span<const Box> bodies, std::span<std::uint32_t> part);
  std::vector<Node> nodes_;
};

}  // namespace gantry::motion
