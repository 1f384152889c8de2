// The space of positions cut into cells that are free, blocked or undecided; any undecided one can be cut finer.
//   CellTree tree(pairs, space);   tree.cut(tree.leaf_at(p));   for (auto n : tree.neighbours(leaf)) ...
// For cells.hpp, which decides what is cut. The same cuts give the same tree: no clock, no chance.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "motion/plan/cell_pair.hpp"

namespace gantry::motion {

class CellTree {
 public:
  enum class State : std::uint8_t { Free, Blocked, Undecided, Cut };

  CellTree(std::vector<CellPair> pairs, const Cell& space);

  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(nodes_.size()); }
  [[nodiscard]] const Cell& space() const { return nodes_.front().cell; }
  [[nodiscard]] const Cell& cell(std::uint32_t node) const { return nodes_[node].cell; }
  [[nodiscard]] State state(std::uint32_t node) const { return nodes_[node].state; }
  /// Undecided, and too small to be cut.
  [[nodiscard]] bool stuck(std::uint32_t node) const { return nodes_[node].stuck; }
  /// Leaves that have a face in common with this one and are not blocked.
  [[nodiscard]] std::span<const std::uint32_t> neighbours(std::uint32_t leaf) const { return nodes_[leaf].beside; }
  [[nodiscard]] std::uint32_t leaf_at(Vec3 p) const;
  /// Leaves that a region comes to, also where it is flat, and that are not blocked.
  [[nodiscard]] std::vector<std::uint32_t> leaves_in(const Cell& region) const;

  /// The directions (unit, x and y above 0) of faces that stand askew in undecided leaves, those in most leaves first.
  [[nodiscard]] std::vector<Vec2> askew() const;

  /// Cuts an undecided leaf in two; false: it is stuck.
  bool cut(std::uint32_t leaf);

 private:
  static constexpr std::uint32_t kNone = 0xffffffffU;
  struct Node {
    Cell cell;
    State state = State::Undecided;
    bool stuck = false;
    std::uint32_t axis = 0, child = kNone;  ///< of a node that is cut: the lower half; the upper one follows it
    double at = 0;
    std::vector<std::uint32_t> pairs;   ///< that are undecided in it
    std::vector<std::uint32_t> beside;  ///< its neighbours
  };

  void judge(std::uint32_t node);
  [[nodiscard]] std::optional<Cut> choose(const Node& node) const;
  [[nodiscard]] bool share_face(const Cell& a, const Cell& b) const;
  void join_halves(std::uint32_t parent);

  std::vector<CellPair> pairs_;
  std::vector<Node> nodes_;
};

}  // namespace gantry::motion
