// Paths through slots that chance does not hit upon, and the proof that there is none, by cells of positions.
//   CellSearch cells(pairs, space);   auto answer = cells.search(from, to, 100000);
// A walk through free cells is a path. When not even free and undecided cells together lead from one end to the other,
// there is none (but for gaps of less than CellPair::kBlur_mm). As long as neither is so, those undecided cells are cut
// that lie on a walk with the fewest of them: each of these walks is a guess where a path may be, and the cuts confirm
// or refute it (counterexample-guided refinement; Clarke, Grumberg, Jha, Lu, Veith 2000). So what no path can need is
// left coarse. The same on every run: no clock, no chance.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "motion/plan/cell_tree.hpp"

namespace gantry::motion {

/// Which end stands in a pocket.
enum class ClosedIn : std::uint8_t { Neither, Start, Goal };

struct CellAnswer {
  enum class Kind : std::uint8_t { Path, NoPath, Undecided } kind = Kind::Undecided;
  std::vector<Vec3> points;  ///< of a path, both ends included
  ClosedIn closed_in = ClosedIn::Neither;
  std::size_t cuts = 0;  ///< that it took
};

class CellSearch {
 public:
  CellSearch(std::vector<CellPair> pairs, const Cell& space) : tree_(std::move(pairs), space) {}
  /// Both ends are within the space and free. Gives up after so many cuts in all; asked again, it goes on from there.
  CellAnswer search(Vec3 from, Vec3 to, std::size_t most_cuts);
  /// Directions of faces that stand askew where it gave up (cell_tree.hpp).
  [[nodiscard]] std::vector<Vec2> askew() const { return tree_.askew(); }

 private:
  enum class Joined : std::uint8_t { Yes, No, Unknown };
  static constexpr std::uint32_t kFar = 0xffffffffU;

  Joined joined(const Cell& here, const Cell& there);
  bool free_leaf_around(Vec3 p);
  [[nodiscard]] std::uint32_t weight(std::uint32_t leaf) const;
  std::uint32_t count(const Cell& from, const Cell& to, std::uint32_t most, std::vector<std::uint32_t>& cells) const;
  void cut_fewest(std::uint32_t fewest);
  bool pocket(const Cell& end);
  double room(const Cell& end, const Cell& other);
  ClosedIn closed_in(const Cell& start, const Cell& goal);
  [[nodiscard]] std::vector<Vec3> path(Vec3 from, Vec3 to) const;

  CellTree tree_;
  std::size_t cuts_ = 0, most_cuts_ = 0;
  bool past_stuck_ = false;  ///< no path is looked for any more, only the proof that there is none
  std::array<std::vector<std::uint32_t>, 2> undecided_;  ///< cells on a walk from either end to a leaf, with the leaf
};

}  // namespace gantry::motion
