#include "motion/plan/shorten.hpp"

#include <algorithm>

namespace gantry::motion {
namespace {

constexpr std::size_t kMany = 100;  // points of which not each is tried with each other
constexpr int kRounds = 3;
constexpr int kHalvings = 5;        // of how far a corner goes
constexpr double kWorth_mm = 0.02;  // what a round must gain for another one

/// The largest share in 0..1 (to a 2^-kHalvings) for which `good` holds, as it does for all smaller ones.
template <class Good>
double largest(const Good& good) {
  double known = 0, step = 1;
  for (int i = 0; i < kHalvings; ++i, step /= 2)
    if (known + step <= 1 && good(known + step)) known += step;
  return known;
}

/// Each corner towards the line between its neighbours.
void pull_in(std::vector<Vec3>& points, const Clear& clear) {
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vec3 a = points[i - 1], b = points[i + 1], v = points[i], ab = b - a;
    const double square = dot(ab, ab);
    const double t = square > 0 ? std::clamp(dot(v - a, ab) / square, 0.0, 1.0) : 0.0;
    const Vec3 inwards = a + ab * t - v;
    const double share = largest([&](double s) { return clear(a, v + inwards * s) && clear(v + inwards * s, b); });
    points[i] = v + inwards * share;
  }
}

/// Each corner by a line across it, as long as the shorter of its sides lets it.
void cut_corners(std::vector<Vec3>& points, const Clear& clear) {
  std::vector<Vec3> out{points.front()};
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vec3 v = points[i], to_a = (out.back() - v), to_b = (points[i + 1] - v);
    const double share = largest([&](double s) { return clear(v + to_a * s, v + to_b * s); });
    if (share > 0) {
      if (share < 1) out.push_back(v + to_a * share);
      if (share < 1) out.push_back(v + to_b * share);
    } else {
      out.push_back(v);
    }
  }
  out.push_back(points.back());
  points = std::move(out);
}

/// From each point straight to one that can be seen from there, in strides that double as long as that goes well: the
/// number of sweeps grows with the number of points, not with its square.
void skip_ahead(std::vector<Vec3>& points, const Clear& clear) {
  std::vector<Vec3> out{points.front()};
  const std::size_t last = points.size() - 1;
  for (std::size_t at = 0, next = 0; at < last; at = next) {
    next = at + 1;
    for (std::size_t stride = 1; next < last && clear(points[at], points[std::min(next + stride, last)]); stride *= 2)
      next = std::min(next + stride, last);
    out.push_back(points[next]);
  }
  points = std::move(out);
}

/// A part of a line that is clear may lie beside it by the last bit of a number.
bool all_clear(const std::vector<Vec3>& points, const Clear& clear) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if (!clear(points[i], points[i + 1])) return false;
  return true;
}

}  // namespace

void leave_out(std::vector<Vec3>& points, const Clear& clear) {
  if (points.size() > kMany) skip_ahead(points, clear);
  std::vector<Vec3> out{points.front()};
  for (std::size_t at = 0; at + 1 < points.size();) {
    std::size_t next = points.size() - 1;
    while (next > at + 1 && !clear(points[at], points[next])) --next;
    out.push_back(points[next]);
    at = next;
  }
  points = std::move(out);
}

void shorten(std::vector<Vec3>& points, const Clear& clear) {
  double length = length_of(points);
  for (int round = 0; round < kRounds && points.size() > 2; ++round) {
    std::vector<Vec3> next = points;
    leave_out(next, clear);
    cut_corners(next, clear);
    pull_in(next, clear);
    const double now = length_of(next);
    if (!(now < length) || !all_clear(next, clear)) break;
    points = std::move(next);
    if (length - now < kWorth_mm) break;
    length = now;
  }
}

}  // namespace gantry::motion
