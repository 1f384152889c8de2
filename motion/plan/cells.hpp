// The space of positions cut into cells that are free, blocked or undecided, finer and finer where it matters: finds
// ways through slots that chance does not hit upon, and proves that there is none.
//   CellSearch cells(pairs, space);   auto answer = cells.search(from, to, 100000);
// Only what has been reached from one of the ends is cut further. A way through free cells is a path. When not even
// free and undecided cells together lead from one end to the other, there is none (but for gaps of less than
// CellPair::kBlur_mm). The same on every run: no clock, no chance.
#pragma once
#include <cstdint>
#include <vector>

#include "motion/plan/cell_pair.hpp"

namespace gantry::motion {

/// Which end stands in a pocket.
enum class ClosedIn : std::uint8_t { Neither, Start, Goal };

struct CellAnswer {
  enum class Kind : std::uint8_t { Path, NoPath, Undecided } kind = Kind::Undecided;
  std::vector<Vec3> points;  ///< of a path, both ends included
  ClosedIn closed_in = ClosedIn::Neither;
};

class CellSearch {
 public:
  CellSearch(std::vector<CellPair> pairs, const Cell& space);
  /// Both ends are within the space and free. Gives up after so many cuts.
  CellAnswer search(Vec3 from, Vec3 to, std::size_t most_cuts);

 private:
  enum class State : std::uint8_t { Free, Blocked, Undecided };
  static constexpr std::uint32_t kNone = 0xffffffffU;
  struct Node {
    Cell cell;
    State state = State::Undecided;
    bool stuck = false;                     ///< too small to be cut
    std::uint16_t halvings = 0;             ///< on the way to this cell
    std::vector<std::uint32_t> pairs;       ///< that are undecided in it
    std::array<bool, 2> queued{}, taken{};  ///< by the search from the start, from the goal
    std::array<bool, 2> refined{};          ///< it stands among what that search cuts finer
    std::array<std::uint32_t, 2> before{kNone, kNone};
    std::array<Vec3, 2> entry{};     ///< where the way to it enters
    std::array<double, 2> way_mm{};  ///< to there
  };
  /// Where an inner node is cut; apart from the rest of the node, because walks down the tree read nothing else.
  struct Split {
    double at = 0;
    std::uint32_t child = kNone;  ///< the lower half; the upper one follows it; none: a leaf
    std::uint32_t axis = 0;
  };
  struct Entry {
    double key = 0;
    std::uint32_t order = 0, node = 0;
    friend bool operator<(const Entry& a, const Entry& b) {  // of a heap: the least first
      return a.key > b.key || (a.key == b.key && a.order > b.order);
    }
  };
  /// All nodes that a walk over free and undecided cells comes to.
  struct Flood {
    std::vector<bool> seen;
    double volume = 0;
    bool at_a_side = false;  ///< of the space, left, right, front or back
  };

  void judge(std::uint32_t node);
  bool cut(std::uint32_t node);
  [[nodiscard]] Cut choose(const Node& node, bool& possible) const;
  [[nodiscard]] std::uint32_t leaf_at(Vec3 p) const;
  /// Leaves with a face in common; in a fixed order.
  void neighbours(std::uint32_t node, std::vector<std::uint32_t>& out) const;
  void collect(std::uint32_t root, const Cell& face, std::uint32_t self, std::vector<std::uint32_t>& out) const;
  [[nodiscard]] bool share_face(const Cell& a, const Cell& b) const;
  bool free_leaf_around(Vec3 p, std::uint32_t& node);
  void offer(std::uint32_t node, std::uint32_t from, std::size_t side);
  void take(std::uint32_t node, std::size_t side);
  void refine(std::uint32_t node, std::size_t side);
  void cut_and_offer(std::uint32_t node, std::size_t side, bool coarse);
  std::uint32_t next(std::size_t side, bool coarse);
  [[nodiscard]] Flood flood(std::uint32_t from) const;
  [[nodiscard]] bool parted();
  [[nodiscard]] CellAnswer no_path() const;
  [[nodiscard]] std::vector<Vec3> way(Vec3 from, Vec3 to) const;

  std::vector<CellPair> pairs_;
  std::vector<Node> nodes_;
  std::vector<Split> splits_;                        ///< of nodes_
  std::array<std::vector<Entry>, 2> near_, coarse_;  ///< heaps: what leads to the other end; what may be reached at all
  std::array<Vec3, 2> ends_{};
  std::uint32_t order_ = 0, met_ = kNone;
  std::size_t cuts_ = 0;
};

}  // namespace gantry::motion
