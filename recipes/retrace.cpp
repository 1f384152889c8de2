#include <algorithm>
#include <cmath>
#include <optional>

#include "recipes/recipe.hpp"

namespace gantry::recipes {
namespace {

double angle(Vec3 a, Vec3 b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

/// A leg from a point that grows over others, all of which it keeps within `off`: it goes through a ball of that radius
/// about each, so its direction lies in a cone about each. Of two cones the widest one is kept that lies in both, which
/// in a plane leaves nothing out; so a leg costs the same however many points it has passed (Zhao and Saalfeld 1997,
/// "Linear-time sleeve-fitting polyline simplification algorithms").
class Leg {
 public:
  Leg(Vec3 from, double off) : from_(from), off_(off) {}

  [[nodiscard]] bool may_end_at(Vec3 p) const {
    const Vec3 ahead = p - from_;
    return norm(ahead) >= farthest_ && (farthest_ <= 0 || angle(axis_, ahead) <= half_);
  }
  /// It may end at `p`, and goes on.
  void pass(Vec3 p) {
    const Vec3 ahead = p - from_;
    const double length = norm(ahead);
    if (length <= off_) return;  // every leg is as near to it as it starts
    const double half = std::asin(off_ / length);
    if (farthest_ <= 0) {
      axis_ = ahead * (1 / length), half_ = half;
    } else if (const double apart = angle(axis_, ahead); apart + half <= half_) {
      axis_ = ahead * (1 / length), half_ = half;
    } else if (apart + half_ > half) {
      const double turn = (half_ - half + apart) / 2;  // of the axis, towards the other
      const Vec3 aside = ahead - axis_ * dot(ahead, axis_);
      axis_ = axis_ * std::cos(turn) + aside * (std::sin(turn) / norm(aside));
      half_ = (half_ + half - apart) / 2;
    }
    farthest_ = length;  // it was not nearer than those before
  }

 private:
  Vec3 from_, axis_{};
  double off_, half_ = 0;
  double farthest_ = 0;  ///< of the points that it has passed, where they are farther than `off`
};

}  // namespace

std::vector<Vec3> without_end(const Bead& bead, double mm) {
  std::vector<Vec3> out = bead.points;
  while (mm > 0 && out.size() > 1) {
    const Vec3 leg = out[out.size() - 2] - out.back();
    const double length = norm(leg);
    if (length > mm) {
      out.back() = out.back() + leg * (mm / length);
      break;
    }
    out.pop_back();
    mm -= length;
  }
  return out;
}

Retrace retrace(const Bead& bead, double back_mm, double off_mm) {
  Retrace back{{bead.points.back()}};
  Leg leg(bead.points.back(), off_mm);
  std::optional<Vec3> last;  // which the leg may end at
  for (std::size_t i = bead.points.size() - 1; i > 0 && back_mm > 0; --i) {
    const Vec3 step = bead.points[i - 1] - bead.points[i];
    const double length = norm(step);
    if (length <= 0) continue;
    const Vec3 p = bead.points[i] + step * std::min(1.0, back_mm / length);
    back_mm -= length;
    ++back.looks;
    if (last && !leg.may_end_at(p)) {
      back.points.push_back(*last);
      leg = Leg(*last, off_mm);
    }
    leg.pass(p);
    last = p;
  }
  if (last) back.points.push_back(*last);
  return back;
}

}  // namespace gantry::recipes
