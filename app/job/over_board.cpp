#include <algorithm>
#include <cmath>
#include <fmt/format.h>
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

std::optional<std::pair<Vec3, Vec3>> Surroundings::over(const Face& face, Vec3 from, Vec3 to, double radius_mm) {
  const Vec2 a = rotated(flat(from) - face.centre, -face.rotation_rad),
             b = rotated(flat(to) - face.centre, -face.rotation_rad), half = face.size * 0.5;
  double first = 0, last = 1;
  clip(a.x, b.x, -half.x - radius_mm, half.x + radius_mm, first, last);
  clip(a.y, b.y, -half.y - radius_mm, half.y + radius_mm, first, last);
  if (first > last) return std::nullopt;
  return std::pair{from + (to - from) * first, from + (to - from) * last};
}

/// Height over a plane is linear along a straight motion, and what is in doubt is convex: the least stands at an end.
std::optional<double> Surroundings::least_height(Vec3 from, Vec3 to, double radius_mm) const {
  const auto part =
      over(faces_.at(kBoard), scene_.board()->from_machine(from), scene_.board()->from_machine(to), radius_mm);
  if (!part) return std::nullopt;
  const auto height = [&](Vec3 p) { return p.z - belief_.doubt->mm(flat(p)); };
  return std::min(height(part->first), height(part->second));
}

Result<void> Surroundings::keeps_gap(std::span<const motion::Segment> segments, const Work& work) const {
  constexpr double kRounding_mm = 1e-3;  // the same motion is a little longer on a slope
  if (!belief_.doubt || uneven_mm_ == 0) return {};
  const double keeps_mm = gap_kept_mm(work);
  for (const motion::SceneBody& body : scene_.head()) {
    if (body.name != needle_) continue;
    const auto tip = [&](const AxisVec& q) {
      return body.solid.centre - Vec3{0, 0, body.half_box.z} + scene_.carried(body, q);
    };
    const std::vector<AxisVec> points = motion::chords(segments);
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
      const Vec3 from = scene_.board()->from_machine(tip(points[k])),
                 to = scene_.board()->from_machine(tip(points[k + 1]));
      for (const auto& [name, face] : faces_) {
        if (name != kBoard && name != work.on) continue;
        const auto part = over(face, from, to, body.half_box.x);
        if (!part) continue;
        const bool first = part->first.z < part->second.z;
        const double height_mm = (first ? part->first : part->second).z - face.top_mm;
        const double asked_mm = std::min(name == work.on ? keeps_mm : work.top_mm + keeps_mm, clearance_mm_);
        if (height_mm < asked_mm - kRounding_mm)
          return fail(Fault::Collision,
                      fmt::format("{} comes within {:.2f} mm of {} at {}", body.name, std::max(0.0, height_mm), name,
                                  scene_.told(tip(points[first ? k : k + 1]))));
      }
    }
  }
  return {};
}

std::optional<BelowBoard> Surroundings::below_board(const std::deque<motion::Segment>& segments,
                                                    const Breath& breath) const {
  constexpr double kRounding_mm = 1e-6;
  if (!belief_.doubt || segments.empty() || uneven_mm_ == 0) return std::nullopt;
  Pauses pause(breath, 64);
  for (const motion::SceneBody& body : scene_.head()) {
    if (body.name != needle_ && body.name != probe_) continue;
    const double radius = body.half_box.x;
    const auto tip = [&](const AxisVec& q) {
      return body.solid.centre - Vec3{0, 0, body.half_box.z} + scene_.carried(body, q);
    };
    double floor = 0;
    bool begun = false;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      pause();
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
