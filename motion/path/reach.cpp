#include "motion/path/reach.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "motion/geometry.hpp"

namespace gantry::motion {
namespace {

struct Reach {
  double low = 0, high = 0;
};
/// How far a geometry takes an axis: the turns of a cubic between its ends, too.
Reach reach(const Geometry& g, std::size_t axis) {
  const double from = point(g, 0)[axis], to = point(g, g.length)[axis];
  Reach out{std::min(from, to), std::max(from, to)};
  if (g.degree < 2 || (g.moving >> axis & 1u) == 0) return out;
  const auto k = static_cast<std::size_t>(std::popcount(g.moving & ((1u << axis) - 1)));
  const double c1 = g.c[3 * k], c2 = g.c[3 * k + 1], c3 = g.c[3 * k + 2];  // its slope: c1 + 2 c2 u + 3 c3 u^2
  const double disc = c2 * c2 - 3 * c1 * c3;
  if (disc < 0) return out;
  const double q = -(c2 + std::copysign(std::sqrt(disc), c2));
  for (const double u : {q / (3 * c3), c1 / q}) {
    if (!(u > parameter(g, 0) && u < parameter(g, g.length))) continue;
    const double at = g.from[axis] + displacement(g, k, u);
    out.low = std::min(out.low, at), out.high = std::max(out.high, at);
  }
  return out;
}

}  // namespace

std::optional<Beyond> beyond_limits(const Limits& limits, std::span<const Segment> segments) {
  constexpr double kRounding = 1e-9;  // mm or rad
  for (const Segment& s : segments)
    for (std::size_t i = 0; i < limits.axes; ++i) {
      const Reach r = reach(s.geometry, i);
      const double by = std::max(limits.axis[i].p_min - r.low, r.high - limits.axis[i].p_max);
      if (by > kRounding) return Beyond{i, by};
    }
  return std::nullopt;
}

}  // namespace gantry::motion
