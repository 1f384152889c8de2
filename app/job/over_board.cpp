#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "app/job/surroundings.hpp"
#include "motion/path/chords.hpp"

namespace gantry::job {
namespace {

/// The part [first, last] of a straight motion in which one coordinate is within [low, high]; empty where first > last.
void clip(double from, double to, double low, double high, double& first, double& last) {
  const double d = to - from;
  if (d == 0) {
    if (from < low || from > high) last = -1;
    return;
  }
  const double a = (low - from) / d, b = (high - from) / d;
  first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
}

}  // namespace

/// Height over a plane is linear along a straight motion, and what is in doubt is convex: the least stands at an end.
std::optional<double> Surroundings::least_height(Vec3 from, Vec3 to, double radius_mm) const {
  const Vec3 a = scene_.board()->from_machine(from), b = scene_.board()->from_machine(to);
  double first = 0, last = 1;
  clip(a.x, b.x, -radius_mm, board_size_.x + radius_mm, first, last);
  clip(a.y, b.y, -radius_mm, board_size_.y + radius_mm, first, last);
  if (first > last) return std::nullopt;
  const auto height = [&](double share) {
    const Vec3 p = a + (b - a) * share;
    return p.z - belief_.doubt->mm(flat(p));
  };
  return std::min(height(first), height(last));
}

std::optional<BelowBoard> Surroundings::below_board(const std::deque<motion::Segment>& segments) const {
  constexpr double kRounding_mm = 1e-6;
  if (!belief_.doubt || segments.empty() || uneven_mm_ == 0) return std::nullopt;
  for (const motion::SceneBody& body : scene_.head()) {
    if (body.name != needle_ && body.name != probe_) continue;
    const double radius = body.half_box.x;
    const auto tip = [&](const AxisVec& q) {
      return body.solid.centre - Vec3{0, 0, body.half_box.z} + scene_.carried(body, q);
    };
    double floor = 0;
    bool begun = false;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const std::vector<AxisVec> points = motion::chords(std::span(&segments[i], 1));
      if (!begun) {
        const Vec3 start = tip(points.front());
        floor = std::min(0.0, least_height(start, start, radius).value_or(0)), begun = true;
      }
      for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        const Vec3 from = tip(points[k]), to = tip(points[k + 1]);
        const auto height = least_height(from, to, radius);
        if (height && *height < floor - kRounding_mm) return BelowBoard{body.name, i, -*height, scene_.told(to)};
      }
    }
  }
  return std::nullopt;
}

}  // namespace gantry::job
