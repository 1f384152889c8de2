#include "bench/path_smooth/curve_bound.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::bench {
namespace {

constexpr std::size_t kWide = 20;  // points to both sides for derivatives, so that rounding has no part in them

struct Place {
  Point d1{}, d2{};
};

/// a = d1 v' + d2 v^2 of each axis within its limit: the most that v' may be, no less than 0.
double gain(const Place& x, double speed, double sign, double a) {
  double best = HUGE_VAL;
  for (std::size_t i = 0; i < 3; ++i)
    if (const double d1 = std::abs(x.d1[i]); d1 > 1e-9)
      best = std::min(best, (a - sign * (x.d1[i] > 0 ? 1 : -1) * x.d2[i] * speed * speed) / d1);
  return std::max(0.0, best);
}

}  // namespace

double bound_on_curve_s(const std::vector<Point>& p, const AxisBounds& l) {
  const std::size_t n = p.size();
  if (n < 2 * kWide + 2) return 0;
  const double h = std::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]);
  std::vector<Place> at(n);
  std::vector<double> most(n, HUGE_VAL), v(n, 0);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t m = std::clamp(k, kWide, n - 1 - kWide);
    const double w = static_cast<double>(kWide) * h;
    for (std::size_t i = 0; i < 3; ++i) {
      at[k].d1[i] = (p[m + kWide][i] - p[m - kWide][i]) / (2 * w);
      at[k].d2[i] = (p[m + kWide][i] - 2 * p[m][i] + p[m - kWide][i]) / (w * w);
      if (const double d1 = std::abs(at[k].d1[i]); d1 > 0) most[k] = std::min(most[k], l.v / d1);
      if (const double d2 = std::abs(at[k].d2[i]); d2 > 0) most[k] = std::min(most[k], std::sqrt(l.a / d2));
    }
  }
  for (std::size_t k = 0; k + 1 < n; ++k)
    v[k + 1] = std::min(most[k + 1], std::sqrt(v[k] * v[k] + 2 * gain(at[k], v[k], 1, l.a) * h));
  double seconds = 0, after = 0;
  v[n - 1] = 0;
  for (std::size_t k = n - 1; k-- > 0;) {
    v[k] = std::min(v[k], std::sqrt(after * after + 2 * gain(at[k + 1], after, -1, l.a) * h));
    seconds += 2 * h / (v[k] + after);
    after = v[k];
  }
  return seconds;
}

}  // namespace gantry::bench
