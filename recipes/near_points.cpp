#include "recipes/near_points.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace gantry::recipes {
namespace {

constexpr std::uint32_t kInALeaf = 8;

}  // namespace

NearPoints::NearPoints(std::vector<Vec3> points)
    : points_(std::move(points)), sorted_(points_.size()), leaf_of_(points_.size()), in_(points_.size(), true) {
  std::iota(sorted_.begin(), sorted_.end(), 0u);
  if (!points_.empty()) build(0, static_cast<std::uint32_t>(points_.size()), kNone);
}

std::uint32_t NearPoints::build(std::uint32_t first, std::uint32_t end, std::uint32_t above) {
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  Vec3 low = points_[sorted_[first]], high = low;
  for (std::uint32_t i = first; i < end; ++i) {
    const Vec3 p = points_[sorted_[i]];
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  nodes_.push_back({low, high, first, end, kNone, kNone, above, end - first});
  if (end - first <= kInALeaf) {
    for (std::uint32_t i = first; i < end; ++i) leaf_of_[sorted_[i]] = self;
    return self;
  }
  const Vec3 edges = high - low;
  const std::size_t longest = edges.x >= edges.y && edges.x >= edges.z ? 0 : edges.y >= edges.z ? 1 : 2;
  const std::uint32_t middle = first + (end - first) / 2;
  const auto at = [&](std::uint32_t i) { return sorted_.begin() + i; };
  std::nth_element(at(first), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(component(points_[a], longest), a) < std::pair(component(points_[b], longest), b);
  });
  const std::uint32_t left = build(first, middle, self), right = build(middle, end, self);
  nodes_[self].left = left, nodes_[self].right = right;
  return self;
}

void NearPoints::count_in(std::uint32_t point, bool in) {
  if (in_[point] == in) return;
  in_[point] = in;
  for (std::uint32_t node = leaf_of_[point]; node != kNone; node = nodes_[node].above)
    in ? ++nodes_[node].in : --nodes_[node].in;
}

void NearPoints::take_out(std::uint32_t point) { count_in(point, false); }
void NearPoints::put_in(std::uint32_t point) { count_in(point, true); }

double NearPoints::square_to(const Node& node, Vec3 at) const {
  const auto beyond = [](double low, double high, double v) { return std::max({0.0, low - v, v - high}); };
  const Vec3 off{beyond(node.low.x, node.high.x, at.x), beyond(node.low.y, node.high.y, at.y),
                 beyond(node.low.z, node.high.z, at.z)};
  return dot(off, off);
}

void NearPoints::nearest(Vec3 at, std::size_t count, std::vector<std::uint32_t>& to) const {
  std::vector<Found> best;
  best.reserve(count + 1);
  if (count > 0 && !nodes_.empty()) look(0, at, count, best);
  to.clear();
  for (const Found& each : best) to.push_back(each.point);
}

void NearPoints::look(std::uint32_t index, Vec3 at, std::size_t count, std::vector<Found>& best) const {
  const Node& node = nodes_[index];
  if (node.in == 0 || (best.size() == count && square_to(node, at) > best.back().square)) return;
  if (node.left == kNone) {
    for (std::uint32_t i = node.first; i < node.end; ++i) {
      const std::uint32_t point = sorted_[i];
      const Vec3 off = points_[point] - at;
      const Found found{dot(off, off), point};
      if (!in_[point] || (best.size() == count && !(found < best.back()))) continue;
      best.insert(std::upper_bound(best.begin(), best.end(), found), found);
      if (best.size() > count) best.pop_back();
    }
    return;
  }
  const bool right_first = square_to(nodes_[node.right], at) < square_to(nodes_[node.left], at);
  look(right_first ? node.right : node.left, at, count, best);
  look(right_first ? node.left : node.right, at, count, best);
}

}  // namespace gantry::recipes
