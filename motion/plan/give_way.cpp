#include "motion/plan/give_way.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "core/vec.hpp"
#include "motion/plan/search_path.hpp"

namespace gantry::motion {
namespace {

constexpr std::array kSteps_mm{0.05, 0.15, 0.4, 1.0, 2.0};
constexpr int kPasses = 3;

/// To the sides, and up: a corner that has come too near to a body never gives way downwards.
constexpr std::array<Vec3, 17> kDirections = [] {
  std::array<Vec3, 17> all{};
  std::size_t n = 0;
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = 0; z <= 1; ++z)
        if (x != 0 || y != 0 || z != 0) all[n++] = {double(x), double(y), double(z)};
  return all;
}();

class Way {
 public:
  Way(const Scene& scene, const Margins& margins, std::vector<AxisVec> points)
      : scene_(scene), margins_(margins), points_(std::move(points)) {}

  /// By one of these steps each time a leg is not free.
  bool make_free(std::span<const double> steps_mm) {
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (!is_allowed(i, points_[i])) return false;
    for (int pass = 0; pass < kPasses; ++pass) {
      bool all = true;
      for (std::size_t i = 1; i < points_.size(); ++i)
        all = (is_free(points_[i - 1], points_[i]) || free_leg(i, steps_mm)) && all;
      if (all) return true;
    }
    return false;
  }
  [[nodiscard]] std::vector<AxisVec> points() && { return std::move(points_); }

 private:
  [[nodiscard]] bool is_end(std::size_t i) const { return i == 0 || i + 1 == points_.size(); }
  [[nodiscard]] bool is_free(const AxisVec& from, const AxisVec& to) const {
    return is_clear(scene_, from, to, margins_);
  }
  [[nodiscard]] bool is_allowed(std::size_t i, const AxisVec& q) const {
    if (is_end(i)) return true;
    const std::size_t z = scene_.z();
    const double lower_end = std::min(points_.front()[z], points_.back()[z]);
    return !beyond_limits(scene_, q, kLimitRounding) &&
           !(margins_.lowest_mm && q[z] < std::min(*margins_.lowest_mm, lower_end));
  }
  [[nodiscard]] AxisVec moved(AxisVec q, Vec3 by) const {
    q[scene_.x()] += by.x, q[scene_.y()] += by.y, q[scene_.z()] += by.z;
    return q;
  }

  /// The leg that ends at `i`: both of its corners, or one, by the least step.
  bool free_leg(std::size_t i, std::span<const double> steps_mm) {
    for (const double step : steps_mm)
      for (const Vec3& direction : kDirections)
        for (const auto& [first, second] : {std::pair{true, true}, {true, false}, {false, true}})
          if (move_leg(i, direction * step, first, second)) return true;
    return false;
  }
  /// Its first point, its second one, or both. False, and nothing is moved: it, or a leg beside it, is not free then.
  bool move_leg(std::size_t i, Vec3 by, bool first, bool second) {
    if ((first && is_end(i - 1)) || (second && is_end(i))) return false;
    const AxisVec a = first ? moved(points_[i - 1], by) : points_[i - 1],
                  b = second ? moved(points_[i], by) : points_[i];
    if (!is_allowed(i - 1, a) || !is_allowed(i, b) || !is_free(a, b)) return false;
    if (first && !is_free(points_[i - 2], a)) return false;
    if (second && !is_free(b, points_[i + 1])) return false;
    points_[i - 1] = a, points_[i] = b;
    return true;
  }

  const Scene& scene_;
  const Margins& margins_;
  std::vector<AxisVec> points_;
};

}  // namespace

std::optional<std::vector<AxisVec>> give_way(const Scene& scene, const std::vector<std::vector<AxisVec>>& ways,
                                             const Margins& margins) {
  for (std::size_t steps = 0; steps <= kSteps_mm.size(); ++steps)
    for (const std::vector<AxisVec>& points : ways) {
      Way way(scene, margins, points);
      if (way.make_free(std::span(kSteps_mm).first(steps))) return std::move(way).points();
    }
  return std::nullopt;
}

}  // namespace gantry::motion
