#include "motion/plan/known_ways.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gantry::motion {
namespace {

constexpr double kNear = 3;  // mm or rad on each axis: what a board may lie off its nominal place, and more

double farthest(const AxisVec& a, const AxisVec& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

}  // namespace

void KnownWays::keep(const AxisVec& from, const AxisVec& to, double clearance_mm, std::vector<AxisVec> points) {
  ways_.push_back({from, to, clearance_mm, std::move(points)});
}

std::optional<std::vector<std::vector<AxisVec>>> KnownWays::like(const AxisVec& from, const AxisVec& to,
                                                                 double clearance_mm) const {
  const Way* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Way& way : ways_) {
    const double ends = std::max(farthest(way.from, from), farthest(way.to, to));
    if (!(ends <= kNear)) continue;
    if (const double off = ends + std::abs(way.clearance_mm - clearance_mm); off < least) least = off, nearest = &way;
  }
  if (nearest == nullptr) return std::nullopt;
  std::vector<std::vector<AxisVec>> ways;
  if (nearest->points.empty()) return ways;
  std::vector<AxisVec> unmoved = nearest->points;
  unmoved.front() = from, unmoved.back() = to;
  ways.push_back(std::move(unmoved));
  // Shares of what the first end has moved by at the way's begin and at its end; the last end has the others.
  for (const auto& [begin, end] : {std::pair{1.0, 0.0}, {0.5, 0.5}, {0.0, 0.0}, {1.0, 1.0}}) {
    std::vector<AxisVec> points = nearest->points;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double along = static_cast<double>(k) / static_cast<double>(points.size() - 1);
      const double share = begin + (end - begin) * along;
      for (std::size_t i = 0; i < from.size(); ++i)
        points[k][i] += share * (from[i] - nearest->from[i]) + (1 - share) * (to[i] - nearest->to[i]);
    }
    points.front() = from, points.back() = to;
    ways.push_back(std::move(points));
  }
  return ways;
}

}  // namespace gantry::motion
