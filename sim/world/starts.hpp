// Where features begin, found by place: a job of a hundred thousand dots is judged in seconds.
//   Starts starts(points);                       // index = feature
//   starts.nearest_first(at, 3, [&](std::size_t feature, double at_least_mm) { ...; return go_on; });
#pragma once
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/vec.hpp"

namespace gantry::sim {

class Starts {
 public:
  Starts() = default;
  explicit Starts(const std::vector<Vec2>& points) {
    for (std::size_t i = 0; i < points.size(); ++i) cells_[key(column(points[i].x), column(points[i].y))].push_back(i);
  }

  /// Visits every start within `reach_mm` (and some beyond), ring by ring outwards. `at_least_mm`: no start of this
  /// ring or of a later one is nearer. Ends when `visit` returns false.
  template <class Visit>
  void nearest_first(Vec2 at, double reach_mm, Visit&& visit) const {
    const std::int64_t x = column(at.x), y = column(at.y);
    const auto rings = static_cast<std::int64_t>(std::ceil(reach_mm / kCell_mm)) + 1;
    for (std::int64_t ring = 0; ring <= rings; ++ring) {
      const double at_least_mm = static_cast<double>(ring > 0 ? ring - 1 : 0) * kCell_mm;
      for (std::int64_t dx = -ring; dx <= ring; ++dx) {
        const bool edge = dx == -ring || dx == ring;
        for (std::int64_t dy = -ring; dy <= ring; dy += edge || ring == 0 ? 1 : 2 * ring) {
          const auto cell = cells_.find(key(x + dx, y + dy));
          if (cell == cells_.end()) continue;
          for (const std::size_t feature : cell->second)
            if (!visit(feature, at_least_mm)) return;
        }
      }
    }
  }

 private:
  static constexpr double kCell_mm = 0.5;
  static std::int64_t column(double mm) { return static_cast<std::int64_t>(std::floor(mm / kCell_mm)); }
  static std::int64_t key(std::int64_t x, std::int64_t y) { return x * 1'000'003 + y; }

  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

}  // namespace gantry::sim
