// The point of a polyline that is nearest from above, found by boxes around pieces of it: a bead of many thousand
// chords is judged in moments.
//   const NearLine line(points);   std::size_t near = 0;
//   for (p : path) { const NearLine::Foot foot = line.foot(p, near); ... }      // near: where to look first
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "core/vec.hpp"

namespace gantry::sim {

class NearLine {
 public:
  struct Foot {
    double distance_mm = std::numeric_limits<double>::infinity();  ///< seen from above
    double z = 0;                                                  ///< of the line there
    std::size_t segment = 0;                                       ///< from which point on
    double along_mm = 0;                                           ///< from there, seen from above
  };

  /// At least one point.
  explicit NearLine(std::span<const Vec3> points) : points_(points.begin(), points.end()) {
    if (points_.size() == 1) points_.push_back(points_.front());
    for (std::size_t from = 0; from + 1 < points_.size(); from += kPiece) {
      Box box{points_[from].x, points_[from].x, points_[from].y, points_[from].y};
      for (std::size_t i = from; i <= std::min(from + kPiece, points_.size() - 1); ++i) {
        box.x_min = std::min(box.x_min, points_[i].x), box.x_max = std::max(box.x_max, points_[i].x);
        box.y_min = std::min(box.y_min, points_[i].y), box.y_max = std::max(box.y_max, points_[i].y);
      }
      boxes_.push_back(box);
    }
  }

  /// `near`: the piece that was nearest to the last point, at first 0; where it starts changes nothing of the answer.
  [[nodiscard]] Foot foot(Vec2 p, std::size_t& near) const {
    Foot best;
    look_at(near, p, best, near);
    for (std::size_t b = 0; b < boxes_.size(); ++b)
      if (distance(boxes_[b], p) < best.distance_mm) look_at(b, p, best, near);
    return best;
  }
  /// On one segment.
  [[nodiscard]] Foot foot_on(std::size_t segment, Vec2 p) const {
    const Vec3 from = points_[segment], along = points_[segment + 1] - from;
    const Vec2 leg{along.x, along.y}, to{p.x - from.x, p.y - from.y};
    const double length2 = dot(leg, leg);
    const double t = length2 > 0 ? std::clamp(dot(to, leg) / length2, 0.0, 1.0) : 0.0;
    return {norm(to - leg * t), from.z + along.z * t, segment, t * std::sqrt(length2)};
  }
  [[nodiscard]] const std::vector<Vec3>& points() const { return points_; }

 private:
  static constexpr std::size_t kPiece = 32;
  struct Box {
    double x_min = 0, x_max = 0, y_min = 0, y_max = 0;
  };

  static double distance(const Box& box, Vec2 p) {
    return std::hypot(std::max({0.0, box.x_min - p.x, p.x - box.x_max}),
                      std::max({0.0, box.y_min - p.y, p.y - box.y_max}));
  }
  void look_at(std::size_t b, Vec2 p, Foot& best, std::size_t& near) const {
    for (std::size_t i = b * kPiece; i < std::min((b + 1) * kPiece, points_.size() - 1); ++i)
      if (const Foot foot = foot_on(i, p); foot.distance_mm < best.distance_mm) best = foot, near = b;
  }

  std::vector<Vec3> points_;
  std::vector<Box> boxes_;
};

}  // namespace gantry::sim
