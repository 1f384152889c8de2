// Lines of a drawing with no more points than can be seen, so that a job of a hundred thousand dots makes a page that
// opens.
//   svg.path(thinned(points, kMost), "actual");
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/vec.hpp"

namespace gantry::record {

/// Leaves out points nearer than half a pixel to the last that was kept; wider where more than `most` would remain.
/// First and last stay.
inline std::vector<Vec2> thinned(const std::vector<Vec2>& points, std::size_t most) {
  for (double least_px = 0.5;; least_px *= 2) {
    std::vector<Vec2> kept;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (kept.empty() || i + 1 == points.size() || norm(points[i] - kept.back()) >= least_px)
        kept.push_back(points[i]);
    if (kept.size() <= most) return kept;
  }
}

/// Of a line that goes on to the right: what it reaches in each column of half a pixel. Its peaks stay.
inline std::vector<Vec2> envelope(const std::vector<Vec2>& points) {
  std::vector<Vec2> kept;
  const auto column = [](Vec2 p) { return std::floor(2 * p.x); };
  for (std::size_t i = 0, end = 0; i < points.size(); i = end) {
    std::size_t low = i, high = i;
    for (end = i; end < points.size() && column(points[end]) == column(points[i]); ++end) {
      if (points[end].y < points[low].y) low = end;
      if (points[end].y > points[high].y) high = end;
    }
    const std::size_t order[] = {i, std::min(low, high), std::max(low, high), end - 1};
    for (std::size_t k = 0; k < 4; ++k)
      if (k == 0 || order[k] != order[k - 1]) kept.push_back(points[order[k]]);
  }
  return kept;
}

}  // namespace gantry::record
