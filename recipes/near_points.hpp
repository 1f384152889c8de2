// Points that are asked for the nearest of them, and may be taken out and put in again: a tree of boxes, each cut
// across its longest edge (Bentley 1990, "K-d trees for semidynamic point sets").
//   NearPoints points(places);   points.take_out(3);   points.nearest(at, 8, found);      // indices, the nearest first
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.hpp"

namespace gantry::recipes {

class NearPoints {
 public:
  /// All of them are in.
  explicit NearPoints(std::vector<Vec3> points);

  void take_out(std::uint32_t point);
  void put_in(std::uint32_t point);

  /// At most `count` of those that are in, the nearest first; of equally near ones the first. `to` is overwritten.
  void nearest(Vec3 at, std::size_t count, std::vector<std::uint32_t>& to) const;

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  struct Node {
    Vec3 low, high;
    std::uint32_t first = 0, end = 0;           ///< of the points: range in sorted_
    std::uint32_t left = kNone, right = kNone;  ///< none: a leaf
    std::uint32_t above = kNone;
    std::uint32_t in = 0;  ///< how many points are in
  };
  struct Found {
    double square = 0;  ///< of the distance, mm2
    std::uint32_t point = 0;
    auto operator<=>(const Found&) const = default;
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t end, std::uint32_t above);
  void count_in(std::uint32_t point, bool in);
  void look(std::uint32_t node, Vec3 at, std::size_t count, std::vector<Found>& best) const;
  [[nodiscard]] double square_to(const Node& node, Vec3 at) const;

  std::vector<Vec3> points_;
  std::vector<std::uint32_t> sorted_;
  std::vector<std::uint32_t> leaf_of_;  ///< of each point
  std::vector<bool> in_;
  std::vector<Node> nodes_;
};

}  // namespace gantry::recipes
