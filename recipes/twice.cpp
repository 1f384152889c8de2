#include "recipes/twice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <unordered_map>

namespace gantry::recipes {
namespace {

constexpr std::size_t kMostLooks = 500;  // at what lies in one cell, for each feature: the time stays bounded

/// Features by what they measure: two whose measures differ by at most kSameSpot_mm each are found by one another.
template <std::size_t N>
class Cells {
 public:
  using Measure = std::array<double, N>;
  void add(const Measure& at, std::size_t index) { cells_[hash(cell(at, 0))].push_back(index); }
  /// Whether `found(index)` says yes to one that may be as near.
  template <class Found>
  bool any(const Measure& at, Found&& found) const {
    const auto low = cell(at, -kSameSpot_mm), high = cell(at, kSameSpot_mm);
    std::size_t looks = 0;
    for (std::size_t corner = 0; corner < (std::size_t{1} << N); ++corner) {
      std::array<std::int64_t, N> here = low;
      bool new_cell = true;
      for (std::size_t i = 0; i < N; ++i) {
        if ((corner >> i & 1u) == 0) continue;
        new_cell = new_cell && high[i] != low[i];
        here[i] = high[i];
      }
      if (!new_cell) continue;
      const auto there = cells_.find(hash(here));
      if (there == cells_.end()) continue;
      for (const std::size_t index : there->second)
        if (found(index) || ++looks >= kMostLooks) return looks < kMostLooks;
    }
    return false;
  }

 private:
  static std::array<std::int64_t, N> cell(const Measure& at, double by) {
    constexpr double kCell_mm = 4 * kSameSpot_mm;
    std::array<std::int64_t, N> out{};
    for (std::size_t i = 0; i < N; ++i) out[i] = std::llround((at[i] + by) / kCell_mm);
    return out;
  }
  static std::uint64_t hash(const std::array<std::int64_t, N>& cell) {
    std::uint64_t h = 1469598103934665603u;
    for (const std::int64_t each : cell) h = (h ^ static_cast<std::uint64_t>(each)) * 1099511628211u, h ^= h >> 29u;
    return h;
  }
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

class Twice {
 public:
  Twice(const Recipe& recipe, config::Mistakes& mistakes) : recipe_(recipe), mistakes_(mistakes) {}

  void look(std::size_t index) {
    if (const auto* dot = std::get_if<Dot>(&recipe_.features[index])) return look(*dot, index);
    look(std::get<Bead>(recipe_.features[index]), index);
  }

 private:
  void look(const Dot& dot, std::size_t index) {
    const Vec3 at{dot.at.x, dot.at.y, dot.height_mm};
    const Cells<3>::Measure measure{at.x, at.y, at.z};
    const bool twice = dots_.any(measure, [&](std::size_t other) {
      const Dot& first = std::get<Dot>(recipe_.features[other]);
      const Vec3 there{first.at.x, first.at.y, first.height_mm};
      if (first.material != dot.material || norm(there - at) >= kSameSpot_mm) return false;
      tell(dot.location,
           fmt::format("dot '{}' lies on dot '{}' of line {}, {:.3g} mm beside it; move one of them, or leave "
                       "it out",
                       dot.id, first.id, first.location.line, norm(there - at)));
      return true;
    });
    if (!twice) dots_.add(measure, index);
  }

  void look(const Bead& bead, std::size_t index) {
    if (bead.points.empty()) return;
    Vec3 low = bead.points.front(), high = low;
    for (const Vec3 p : bead.points) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const Cells<4>::Measure measure{low.x, low.y, high.x, high.y};
    const bool twice = beads_.any(measure, [&](std::size_t other) {
      const Bead& first = std::get<Bead>(recipe_.features[other]);
      if (first.material != bead.material || !same(first.points, bead.points)) return false;
      tell(bead.location,
           fmt::format("bead '{}' lies on bead '{}' of line {} over all its length; move one of them, or "
                       "leave it out",
                       bead.id, first.id, first.location.line));
      return true;
    });
    if (!twice) beads_.add(measure, index);
  }

  static bool same(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    const auto near = [](Vec3 p, Vec3 q) { return norm(p - q) < kSameSpot_mm; };
    return a.size() == b.size() &&
           (std::equal(a.begin(), a.end(), b.begin(), near) || std::equal(a.begin(), a.end(), b.rbegin(), near));
  }

  void tell(Location location, std::string words) {
    if (told_.insert({location.line, location.column}).second)
      mistakes_.add(Fault::Inconsistent, std::move(words), location);
  }

  const Recipe& recipe_;
  config::Mistakes& mistakes_;
  Cells<3> dots_;
  Cells<4> beads_;
  std::set<std::pair<int, int>> told_;
};

double distance(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 along = b - a;
  const double square = dot(along, along);
  const double u = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0;
  return norm(p - (a + along * u));
}

}  // namespace

void check_twice(const Recipe& recipe, config::Mistakes& mistakes) {
  Twice twice(recipe, mistakes);
  for (std::size_t i = 0; i < recipe.features.size(); ++i) twice.look(i);
}

const Feature* feature_near(const Recipe& recipe, Vec2 at, double within_mm) {
  const auto near = [&](const Feature& feature) {
    if (const auto* one = std::get_if<Dot>(&feature)) return norm(one->at - at) < within_mm;
    const std::vector<Vec3>& points = std::get<Bead>(feature).points;
    for (std::size_t i = 1; i < points.size(); ++i)
      if (distance(at, flat(points[i - 1]), flat(points[i])) < within_mm) return true;
    return false;
  };
  const auto found = std::find_if(recipe.features.begin(), recipe.features.end(), near);
  return found == recipe.features.end() ? nullptr : &*found;
}

}  // namespace gantry::recipes
