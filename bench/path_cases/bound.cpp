#include "bench/path_cases/bound.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::bench {
namespace {

using Point = std::array<double, 3>;

/// A path that is within the tolerance of both legs of a right-angled corner is sqrt(2) times as far from its vertex.
constexpr double kOfVertex = 1.5;

// Least time over a distance d between two moments at which the axis stands (with any acceleration): full acceleration
// and full braking.
double between_turns(double d, const BoundLimits& l) {
  if (d <= 0) return 0;
  const double v = std::min(l.v, l.speed);
  return d >= v * v / l.a ? d / v + v / l.a : 2 * std::sqrt(d / l.a);
}

// One axis. Where its coordinate along the polyline turns back by more than that slack twice, the axis itself has to
// turn back, and stands for a moment; between two turns it covers their distance but for the slack. Start and end
// stand.
double turns_s(const std::vector<Point>& points, std::size_t axis, const BoundLimits& l) {
  const double least = 2 * kOfVertex * l.tolerance;
  std::vector<double> turns{points.front()[axis]};
  double low = turns.front(), high = low;
  int direction = 0;
  for (const Point& p : points) {
    const double x = p[axis];
    low = std::min(low, x), high = std::max(high, x);
    if (direction >= 0 && x < high - least) {
      if (direction > 0) turns.push_back(high);
      direction = -1, low = x, high = x;
    } else if (direction <= 0 && x > low + least) {
      if (direction < 0) turns.push_back(low);
      direction = 1, low = x, high = x;
    }
  }
  turns.push_back(points.back()[axis]);
  double sum = 0;
  for (std::size_t k = 1; k < turns.size(); ++k) sum += between_turns(std::abs(turns[k] - turns[k - 1]) - least, l);
  return sum;
}

// From near one point to near a later one, no axis is faster than its limit. Points farther apart lose less to the
// tolerance, nearer ones less to the bend between them: every stride gives a bound.
double speed_s(const std::vector<Point>& points, std::size_t stride, const BoundLimits& l) {
  double sum = 0;
  for (std::size_t k = 0; k + 1 < points.size(); k += stride) {
    const Point &a = points[k], &b = points[std::min(k + stride, points.size() - 1)];
    double axis = 0, square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      axis = std::max(axis, std::abs(b[i] - a[i]));
      square += (b[i] - a[i]) * (b[i] - a[i]);
    }
    sum += std::max(
        {0.0, (axis - 2 * kOfVertex * l.tolerance) / l.v, (std::sqrt(square) - 2 * kOfVertex * l.tolerance) / l.speed});
  }
  return sum;
}

}  // namespace

double bound_s(const std::vector<std::array<double, 3>>& points, const BoundLimits& limits) {
  double best = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) best = std::max(best, turns_s(points, axis, limits));
  for (std::size_t stride = 1; stride < 2 * points.size(); stride *= 2)
    best = std::max(best, speed_s(points, stride, limits));
  return best;
}

}  // namespace gantry::bench
