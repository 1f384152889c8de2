#include "app/record/tip_lines.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/record/report_geometry.hpp"

namespace gantry::record {
namespace {

constexpr std::size_t kMostPoints = 20000;  // of all lines
constexpr std::size_t kMostBeads = 4000;    // a bead has two points at least
constexpr std::size_t kMostDots = 10000;    //
constexpr double kFinest_mm = 0.01, kCoarsest_mm = 10;
constexpr double kDot_mm = 0.3;      // what the tip does with the valve open within this is a dot
constexpr std::size_t kPiece = 512;  // points that are simplified together

bool finite(Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

double distance_to_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 along = b - a;
  const double square = dot(along, along);
  const double t = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
  return norm(p - (a + along * t));
}

double reach(std::span<const Vec3> points) {
  double r = 0;
  for (const Vec3 p : points) r = std::max(r, norm(p - points.front()));
  return r;
}

template <class T>
std::size_t keep_every(std::vector<T>& all, std::size_t most) {
  const std::size_t every = std::max<std::size_t>(1, (all.size() + most - 1) / most);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all.size(); i += every)
    if (kept++ != i) all[kept - 1] = std::move(all[i]);
  all.resize(kept);
  return every;
}

/// As fine as the bound on the number of points allows.
TipLines thinned(TipLines all) {
  all.every_bead = keep_every(all.beads, kMostBeads);
  all.every_dot = keep_every(all.dots, kMostDots);
  for (double tolerance = kFinest_mm;; tolerance *= 2) {
    TipLines out;
    std::size_t count = 0;
    for (const auto lines : {&TipLines::travel, &TipLines::beads})
      for (const std::vector<Vec3>& line : all.*lines)
        count += (out.*lines).emplace_back(simplified(line, tolerance)).size();
    if (count > kMostPoints && tolerance * 2 <= kCoarsest_mm) continue;
    out.dots = std::move(all.dots);
    out.within_mm = tolerance, out.every_bead = all.every_bead, out.every_dot = all.every_dot;
    return out;
  }
}

}  // namespace

std::vector<Vec3> simplified(std::span<const Vec3> points, double tolerance_mm) {
  if (points.size() < 3) return {points.begin(), points.end()};
  std::vector<char> kept(points.size(), 0);
  std::vector<std::pair<std::size_t, std::size_t>> open;
  for (std::size_t i = 0; i + 1 < points.size(); i += kPiece)
    open.emplace_back(i, std::min(i + kPiece, points.size() - 1));
  for (const auto& [first, last] : open) kept[first] = kept[last] = 1;
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    std::size_t farthest = first;
    double most = tolerance_mm;
    for (std::size_t i = first + 1; i < last; ++i)
      if (const double d = distance_to_segment(points[i], points[first], points[last]); d > most)
        most = d, farthest = i;
    if (farthest == first) continue;
    kept[farthest] = 1;
    open.emplace_back(first, farthest), open.emplace_back(farthest, last);
  }
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (kept[i] != 0) out.push_back(points[i]);
  return out;
}

TipLines tip_lines(const JobResult& r) {
  TipLines all;
  std::vector<Vec3> open;  // since the valve was opened
  const auto close = [&] {
    if (open.empty()) return;
    if (reach(open) < kDot_mm)
      all.dots.push_back(open.front());
    else
      all.beads.push_back(open);
    open.clear();
  };
  const PathPoint* before = nullptr;
  for (const PathPoint& p : r.actual.empty() ? r.planned : r.actual) {
    const Vec3 tip = machine_tip_at(r, p);
    if (!finite(tip)) continue;
    const bool new_block = before == nullptr || before->block != p.block;
    if (new_block || !p.valve) close();
    if (new_block) all.travel.emplace_back();
    all.travel.back().push_back(tip);
    if (p.valve) open.push_back(tip);
    before = &p;
  }
  close();
  return thinned(std::move(all));
}

TipLines asked_lines(const JobResult& r) {
  TipLines all;
  for (const std::vector<Vec3>& points : r.drawing.asked) {
    if (points.empty() || !std::all_of(points.begin(), points.end(), finite)) continue;
    if (points.size() == 1)
      all.dots.push_back(points.front());
    else
      all.beads.push_back(points);
  }
  return thinned(std::move(all));
}

}  // namespace gantry::record
