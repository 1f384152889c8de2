#include "motion/plan/join_paths.hpp"

#include <algorithm>
#include <limits>

namespace gantry::motion {

/// Dijkstra over all corners; whether one is seen from another is asked only where that could make the path shorter.
std::vector<Vec3> join_paths(const std::vector<std::vector<Vec3>>& paths, const Clear& clear) {
  struct Corner {
    Vec3 at;
    double length_mm = std::numeric_limits<double>::infinity();  ///< of the shortest path to it
    std::size_t before = 0;
    bool done = false;
  };
  const std::vector<Vec3>& shortest = *std::min_element(
      paths.begin(), paths.end(), [](const auto& a, const auto& b) { return length_of(a) < length_of(b); });
  const Vec3 goal = shortest.back();
  std::vector<Corner> corners{{shortest.front(), 0, 0, false}};
  for (std::size_t i = 1; i < shortest.size(); ++i)
    corners.push_back({shortest[i], corners.back().length_mm + norm(shortest[i] - shortest[i - 1]), i - 1, false});
  const std::size_t last = corners.size() - 1;
  for (const auto& path : paths)
    for (std::size_t i = 1; &path != &shortest && i + 1 < path.size(); ++i) corners.push_back({path[i]});

  while (!corners[last].done) {
    std::size_t from = last;
    for (std::size_t i = 0; i < corners.size(); ++i)
      if (!corners[i].done && corners[i].length_mm < corners[from].length_mm) from = i;
    corners[from].done = true;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double length = corners[from].length_mm + norm(corners[i].at - corners[from].at);
      if (corners[i].done || length >= corners[i].length_mm) continue;
      if (length + norm(goal - corners[i].at) > corners[last].length_mm) continue;
      if (clear(corners[from].at, corners[i].at)) corners[i].length_mm = length, corners[i].before = from;
    }
  }
  std::vector<Vec3> out{goal};
  for (std::size_t i = last; i != 0; i = corners[i].before) out.push_back(corners[corners[i].before].at);
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace gantry::motion
