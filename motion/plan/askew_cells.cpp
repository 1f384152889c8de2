#include "motion/plan/askew_cells.hpp"

#include <algorithm>

namespace gantry::motion {
namespace {

// The sides of the space stand this far beyond it, so that no position on a side is taken for blocked (kBlur_mm); what
// a path leaves the space by is taken back.
constexpr double kBeyond_mm = 1.5 * CellPair::kBlur_mm;
constexpr double kThick_mm = 1e6;

/// What is beyond the four upright sides of the space.
std::vector<KeptApart> around(const Cell& space) {
  const Vec3 centre = space.centre(), half = space.half();
  std::vector<KeptApart> out;
  for (const double side : {-1.0, 1.0})
    for (const bool of_x : {true, false}) {
      Difference d;
      d.half = {kThick_mm, kThick_mm}, d.half_height = kThick_mm;
      d.generator = {Vec2{kThick_mm, 0}, Vec2{0, kThick_mm}};
      d.centre = centre;
      (of_x ? d.centre.x : d.centre.y) += side * ((of_x ? half.x : half.y) + kBeyond_mm + kThick_mm);
      out.push_back({d, 0});
    }
  return out;
}

}  // namespace

std::vector<Vec3> path_along(const std::vector<KeptApart>& pairs, const Cell& space, Vec2 x, Vec3 from, Vec3 to,
                             std::size_t most_cuts) {
  const auto turned = [x](Vec3 p) { return Vec3{dot(x, flat(p)), cross(x, flat(p)), p.z}; };
  const auto back = [x](Vec3 p) { return Vec3{x.x * p.x - x.y * p.y, x.y * p.x + x.x * p.y, p.z}; };
  std::vector<CellPair> cells;
  for (const KeptApart& p : pairs) cells.emplace_back(in_axes_along(p.difference, x), p.margin_mm);
  for (const KeptApart& p : around(space)) cells.emplace_back(in_axes_along(p.difference, x), p.margin_mm);
  Cell all{{1e300, 1e300, space.low[2]}, {-1e300, -1e300, space.high[2]}};
  for (const double at_x : {space.low[0] - kBeyond_mm, space.high[0] + kBeyond_mm})
    for (const double at_y : {space.low[1] - kBeyond_mm, space.high[1] + kBeyond_mm}) {
      const Vec3 corner = turned({at_x, at_y, 0});
      all.low[0] = std::min(all.low[0], corner.x), all.high[0] = std::max(all.high[0], corner.x);
      all.low[1] = std::min(all.low[1], corner.y), all.high[1] = std::max(all.high[1], corner.y);
    }
  CellAnswer found = CellSearch(std::move(cells), all).search(turned(from), turned(to), most_cuts);
  if (found.kind != CellAnswer::Kind::Path) return {};
  for (Vec3& p : found.points) {
    p = back(p);
    p.x = std::clamp(p.x, space.low[0], space.high[0]), p.y = std::clamp(p.y, space.low[1], space.high[1]);
  }
  found.points.front() = from, found.points.back() = to;
  return std::move(found.points);
}

}  // namespace gantry::motion
