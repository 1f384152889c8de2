#include "motion/plan/cell_pair.hpp"

#include <algorithm>
#include <cmath>

#include "motion/plan/sweep.hpp"

namespace gantry::motion {
namespace {

// Cells are not halved any further. Where room and blockage are apart by kBlur_mm, a cell that small is one or the
// other; where bodies may overlap nothing is ever blocked, and halving more would find nothing out.
constexpr double kSmallest_mm = 1e-7;
constexpr double kSmallestOfOverlap_mm = 2e-3;
constexpr double kInside = 1e-9;  // a cut leaves at least this much on both sides, mm

bool within(const Cell& cell, std::size_t axis, double at) {
  return at > cell.low[axis] + kInside && at < cell.high[axis] - kInside;
}

}  // namespace

CellPair::CellPair(const Difference& difference, double margin_mm) : d_(difference), margin_(margin_mm) {
  aligned_ = !d_.eight && (std::abs(d_.sin) < kAligned || std::abs(d_.cos) < kAligned);
  at_ = {d_.centre.x, d_.centre.y, d_.centre.z};
  const double more = margin_ + kBlur_mm / 2;
  reach_ = {reach(d_, {1, 0, 0}) + more, reach(d_, {0, 1, 0}) + more, reach(d_, {0, 0, 1}) + more};
  const bool turned = std::abs(d_.cos) < kAligned;
  straight_ = {aligned_ ? (turned ? d_.half.y : d_.half.x) : -1, aligned_ ? (turned ? d_.half.x : d_.half.y) : -1,
               d_.half_height};
}

bool CellPair::free(const Cell& cell) const {
  const Vec3 centre = cell.centre(), half = cell.half(), to = d_.centre - centre;
  const double asked = margin_ + kContact_mm;
  const auto room = [&](Vec3 n) {
    return std::abs(dot(n, to)) - reach(d_, n) -
           (std::abs(n.x) * half.x + std::abs(n.y) * half.y + std::abs(n.z) * half.z);
  };
  if (room({1, 0, 0}) > asked || room({0, 1, 0}) > asked || room({0, 0, 1}) > asked) return true;
  const Away a = away(d_, centre);
  if (a.direction == Vec3{}) return false;
  if (room(a.direction) > asked) return true;
  if (aligned_) return false;
  for (const Vec2 g : d_.generator) {
    const double length = std::sqrt(dot(g, g));
    if (length > 0 && room({-g.y / length, g.x / length, 0}) > asked) return true;
  }
  return false;
}

bool CellPair::blocked(const Cell& cell) const {
  if (margin_ < 0) return false;  // an overlap is allowed here: what is sure is not looked for
  const double reaches = margin_ + d_.ball + 0.9 * kBlur_mm;
  const double up = std::max(
      {0.0, std::abs(cell.low[2] - at_[2]) - d_.half_height, std::abs(cell.high[2] - at_[2]) - d_.half_height});
  if (up > reaches) return false;
  // Distances from a convex figure are greatest at corners; the plane's and Z's are independent of each other.
  for (const double x : {cell.low[0], cell.high[0]})
    for (const double y : {cell.low[1], cell.high[1]}) {
      const double flat = std::max(0.0, flat_distance(d_, {x - at_[0], y - at_[1]}) - d_.disc);
      if (flat * flat + up * up > reaches * reaches) return false;
    }
  return true;
}

std::optional<Cut> CellPair::cut(const Cell& cell) const {
  std::optional<Cut> best;
  double most = 0;
  const auto offer = [&](std::size_t axis, double from_centre) {
    for (const double side : {-1.0, 1.0}) {
      const double at = at_[axis] + side * from_centre;
      if (!within(cell, axis, at)) continue;
      const double off = (side > 0 ? cell.high[axis] - at : at - cell.low[axis]) / (cell.high[axis] - cell.low[axis]);
      if (off > most) most = off, best = Cut{axis, at};
    }
  };
  for (std::size_t axis = 0; axis < 3; ++axis) offer(axis, reach_[axis]);
  if (best) return best;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (straight_[axis] > 0 && reach_[axis] - straight_[axis] > 2 * kBlur_mm) offer(axis, straight_[axis]);
  if (best) return best;
  const bool upright = cell.low[2] >= at_[2] - d_.half_height && cell.high[2] <= at_[2] + d_.half_height;
  std::size_t longest = 0;
  for (std::size_t axis = 1; axis < (upright ? 2U : 3U); ++axis)
    if (cell.high[axis] - cell.low[axis] > cell.high[longest] - cell.low[longest]) longest = axis;
  if (cell.high[longest] - cell.low[longest] < (margin_ < 0 ? kSmallestOfOverlap_mm : kSmallest_mm))
    return std::nullopt;
  return Cut{longest, (cell.low[longest] + cell.high[longest]) / 2};
}

std::optional<double> CellPair::face(const Cell& cell, std::size_t axis, double middle) const {
  const double low = at_[axis] - reach_[axis], high = at_[axis] + reach_[axis];
  const double first = std::abs(low - middle) < std::abs(high - middle) ? low : high;
  for (const double at : {first, first == low ? high : low})
    if (within(cell, axis, at)) return at;
  return std::nullopt;
}

double CellPair::share(const Cell& cell) const {
  double share = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = cell.high[axis] - cell.low[axis];
    if (size <= 0) continue;
    share *= std::max(0.0, std::min(cell.high[axis], at_[axis] + reach_[axis]) -
                               std::max(cell.low[axis], at_[axis] - reach_[axis])) /
             size;
  }
  return share;
}

}  // namespace gantry::motion
