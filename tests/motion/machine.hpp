// A machine for motion tests: X Y Z in mm, C and U (turn and lift) of which C is rotary; and what every stream of axis
// vectors has to obey.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "motion/types.hpp"

namespace gantry::motion::test {

inline Limits machine() {
  Limits m;
  m.axes = 5;
  m.axis[0] = {-10, 610, 800, 5000, 80000};
  m.axis[1] = {-10, 510, 700, 4000, 60000};
  m.axis[2] = {-120, 5, 300, 3000, 50000};
  m.axis[3] = {-7, 7, 12, 120, 2400};
  m.axis[4] = {-1, 41, 100, 1000, 20000};
  m.linear = {true, true, true};
  m.tick_s = 0.001;
  return m;
}

/// Largest use of an axis limit by finite differences of a stream of positions at spacing h: an n-th difference over
/// h^n is a mean of the n-th derivative, so that a stream within its limits never shows more than 1 (plus rounding).
struct Use {
  double v = 0, a = 0, j = 0;
};
inline Use limit_use(const Limits& m, const std::vector<AxisVec>& q, double h) {
  Use use;
  for (std::size_t i = 0; i < m.axes; ++i)
    for (std::size_t n = 3; n < q.size(); ++n) {
      const double d1 = q[n][i] - q[n - 1][i];
      const double d2 = q[n][i] - 2 * q[n - 1][i] + q[n - 2][i];
      const double d3 = q[n][i] - 3 * q[n - 1][i] + 3 * q[n - 2][i] - q[n - 3][i];
      // Rounding of q: half a unit in the last place each, at most 8 of them in the third difference.
      const double eps = 2.3e-16 * std::max({std::abs(q[n][i]), std::abs(q[n - 3][i]), 1.0});
      use.v = std::max(use.v, (std::abs(d1) - 2 * eps) / h / m.axis[i].v_max);
      use.a = std::max(use.a, (std::abs(d2) - 4 * eps) / (h * h) / m.axis[i].a_max);
      use.j = std::max(use.j, (std::abs(d3) - 8 * eps) / (h * h * h) / m.axis[i].j_max);
    }
  return use;
}

/// Distance of point q to the segment a-b in X Y Z.
inline double distance_to_leg(const AxisVec& q, const AxisVec& a, const AxisVec& b) {
  double ab = 0, aq = 0;
  for (std::size_t i = 0; i < 3; ++i) ab += (b[i] - a[i]) * (b[i] - a[i]), aq += (q[i] - a[i]) * (b[i] - a[i]);
  const double t = ab > 0 ? std::clamp(aq / ab, 0.0, 1.0) : 0;
  double d = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double e = q[i] - a[i] - t * (b[i] - a[i]);
    d += e * e;
  }
  return std::sqrt(d);
}
inline double distance_to_polyline(const AxisVec& q, const std::vector<AxisVec>& points) {
  double best = 1e300;
  for (std::size_t k = 1; k < points.size(); ++k) best = std::min(best, distance_to_leg(q, points[k - 1], points[k]));
  return best;
}

/// A polyline as beads are: 2 to 8 points in a board-sized window, Z following a tilted surface, C turning along at
/// times; legs from 0.05 mm to 60 mm, reversals and repeated points among them.
inline std::vector<AxisVec> random_polyline(std::mt19937_64& random) {
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  const double zx = uniform(-0.02, 0.02), zy = uniform(-0.02, 0.02), z0 = uniform(-60, -40);
  const bool turns = uniform(0, 1) < 0.3;
  const auto lay = [&](double x, double y, double c) {
    AxisVec q{};
    q[0] = x, q[1] = y, q[2] = z0 + zx * x + zy * y, q[3] = c, q[4] = 12;
    return q;
  };
  double x = uniform(150, 450), y = uniform(150, 350), c = uniform(-1, 1), heading = uniform(0, 6.3);
  std::vector<AxisVec> points{lay(x, y, c)};
  const int n = 1 + static_cast<int>(uniform(0, 6.99));
  for (int k = 0; k < n; ++k) {
    const double kind = uniform(0, 1), length = std::pow(10.0, uniform(-1.3, 1.8));
    if (kind < 0.05) {
      points.push_back(points.back());
      continue;
    }
    heading += kind < 0.1 ? 3.14159265358979 : kind < 0.2 ? 0.0 : kind < 0.4 ? 1.5707963267948966 : uniform(-2.8, 2.8);
    x = std::clamp(x + length * std::cos(heading), 100.0, 500.0);
    y = std::clamp(y + length * std::sin(heading), 100.0, 400.0);
    if (turns) c += std::clamp(uniform(-0.1, 0.1) * length, -0.4, 0.4);
    points.push_back(lay(x, y, c));
  }
  return points;
}

inline std::string text(const std::vector<AxisVec>& points) {
  std::string out;
  char line[120];
  for (const AxisVec& q : points) {
    std::snprintf(line, sizeof line, "(%.17g, %.17g, %.17g, %.17g) ", q[0], q[1], q[2], q[3]);
    out += line;
  }
  return out;
}

}  // namespace gantry::motion::test
