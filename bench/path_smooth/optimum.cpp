#include "bench/path_smooth/optimum.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gantry::bench {
namespace {

constexpr double kBoundStep_mm = 0.05;  // of the bound without jerk, which tells how far the grid of speeds has to go

/// A place on the path, and how far speed and acceleration go there.
struct GridPlace {
  double s = 0;
  motion::CurveJet q{};
  double v_top = 0, a_top = 0;
};

class Path {
 public:
  Path(std::span<const motion::Curve> curves, const motion::Limits& limits) : curves_(curves), limits_(limits) {
    for (const motion::Curve& c : curves) ends_.push_back(length() + c.length);
  }
  [[nodiscard]] double length() const { return ends_.empty() ? 0 : ends_.back(); }
  [[nodiscard]] motion::CurveJet at(double s) const {
    const auto k = static_cast<std::size_t>(
        std::min<std::ptrdiff_t>(std::upper_bound(ends_.begin(), ends_.end(), s) - ends_.begin(),
                                 static_cast<std::ptrdiff_t>(ends_.size()) - 1));
    const motion::Curve& c = curves_[k];
    return jet(c, std::clamp(s - (ends_[k] - c.length), 0.0, c.length), limits_.axes);
  }
  /// The least over the axes of of(axis) / |q'|.
  template <class Of>
  [[nodiscard]] double along(const motion::CurveJet& q, Of of) const {
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < limits_.axes; ++i)
      if (const double d = std::abs(q.d1[i]); d > 1e-9) least = std::min(least, of(i) / d);
    return least;
  }
  [[nodiscard]] double jerk_along(const motion::CurveJet& q) const {
    return along(q, [&](std::size_t i) { return limits_.axis[i].j_max; });
  }
  /// The most that v' may be, with its sign.
  [[nodiscard]] double gain(const motion::CurveJet& q, double v, double sign) const {
    return std::max(0.0, along(q, [&](std::size_t i) {
                      return limits_.axis[i].a_max - sign * (q.d1[i] > 0 ? 1 : -1) * q.d2[i] * v * v;
                    }));
  }
  [[nodiscard]] double most(const motion::CurveJet& q) const {
    double v = along(q, [&](std::size_t i) { return limits_.axis[i].v_max; });
    for (std::size_t i = 0; i < limits_.axes; ++i)
      if (const double d = std::abs(q.d2[i]); d > 0) v = std::min(v, std::sqrt(limits_.axis[i].a_max / d));
    return v;
  }
  /// Speed and acceleration of the axes within their limits.
  [[nodiscard]] bool allowed(const motion::CurveJet& q, double v, double a) const {
    for (std::size_t i = 0; i < limits_.axes; ++i)
      if (std::abs(q.d1[i] * v) > limits_.axis[i].v_max ||
          std::abs(q.d1[i] * a + q.d2[i] * v * v) > limits_.axis[i].a_max)
        return false;
    return true;
  }
  /// What the axes' jerk leaves of the path's: from first to second.
  [[nodiscard]] std::pair<double, double> jerks(const motion::CurveJet& q, double v, double a) const {
    double low = -HUGE_VAL, high = HUGE_VAL;
    for (std::size_t i = 0; i < limits_.axes; ++i) {
      const double bent = 3 * q.d2[i] * v * a + q.d3[i] * v * v * v, j = limits_.axis[i].j_max;
      if (std::abs(q.d1[i]) < 1e-9) {
        if (std::abs(bent) > j) return {1, 0};
        continue;
      }
      const double x = (-j - bent) / q.d1[i], y = (j - bent) / q.d1[i];
      low = std::max(low, std::min(x, y)), high = std::min(high, std::max(x, y));
    }
    return {low, high};
  }

 private:
  std::span<const motion::Curve> curves_;
  const motion::Limits& limits_;
  std::vector<double> ends_;
};

/// Speed after length s from rest at jerk j: s = j t^3/6, v = j t^2/2.
double from_rest(double j, double s) { return std::cbrt(4.5 * j * s * s); }

/// The bound without jerk, at even steps.
std::vector<double> without_jerk(const Path& path, std::size_t n) {
  const double h = path.length() / static_cast<double>(n);
  std::vector<motion::CurveJet> q;
  for (std::size_t k = 0; k <= n; ++k) q.push_back(path.at(h * static_cast<double>(k)));
  std::vector<double> v(n + 1, 0);
  for (std::size_t k = 0; k < n; ++k)
    v[k + 1] = std::min(path.most(q[k + 1]), std::sqrt(v[k] * v[k] + 2 * h * path.gain(q[k], v[k], 1)));
  v[n] = 0;
  for (std::size_t k = n; k-- > 0;)
    v[k] = std::min(v[k], std::sqrt(v[k + 1] * v[k + 1] + 2 * h * path.gain(q[k + 1], v[k + 1], -1)));
  return v;
}

/// From a little after the start, where the tool comes to at full jerk, to a little before the end.
std::vector<GridPlace> places(const Path& path, double every_s) {
  constexpr double kFirst_s = 0.002, kRoom = 1.02;
  const auto n = static_cast<std::size_t>(std::ceil(path.length() / kBoundStep_mm));
  const std::vector<double> bound = without_jerk(path, n);
  const double j0 = path.jerk_along(path.at(0)), j1 = path.jerk_along(path.at(path.length()));
  const double first = j0 * std::pow(kFirst_s, 3) / 6, last = path.length() - j1 * std::pow(kFirst_s, 3) / 6;
  std::vector<GridPlace> out;
  for (double s = first;;) {
    GridPlace p{s, path.at(s)};
    const double at = s / path.length() * static_cast<double>(n);
    const auto k = std::min(n - 1, static_cast<std::size_t>(at));
    const double cap = std::max(bound[k], bound[k + 1]);
    p.v_top = kRoom * std::min({cap, from_rest(j0, s) * kRoom, from_rest(j1, path.length() - s) * kRoom});
    p.a_top = kRoom * std::min(path.along(p.q, [&](std::size_t) { return 1.5 * path.gain(p.q, 0, 1); }),
                               std::sqrt(2 * path.jerk_along(p.q) * p.v_top));
    out.push_back(p);
    if (s >= last) return out;
    // So far as the tool comes in this time, slower near the ends.
    const double t = std::cbrt(6 * s / j0) + every_s, left = std::cbrt(6 * (path.length() - s) / j1) - every_s;
    const double by_start = j0 * t * t * t / 6 - s,
                 by_end = left > 0 ? path.length() - s - j1 * left * left * left / 6 : HUGE_VAL;
    const double next = s + std::min({by_start, by_end, every_s * std::max(p.v_top, 1e-3)});
    s = next > last - 1e-9 || last - next < 0.3 * (next - s) ? last : next;
  }
}

/// Times to the end from speeds (from 0 to v_top) and accelerations (from -a_top to a_top) at a place.
struct Times {
  std::size_t speeds, accelerations;
  const GridPlace* place;
  std::vector<double> t;
  [[nodiscard]] double v(std::size_t n) const {
    return place->v_top * static_cast<double>(n + 1) / static_cast<double>(speeds);
  }
  [[nodiscard]] double a(std::size_t m) const {
    return place->a_top * (2 * static_cast<double>(m) / static_cast<double>(accelerations - 1) - 1);
  }
  /// Between four of them; what is impossible does not count where another is possible.
  [[nodiscard]] double between(double v, double a) const {
    const double x = v / place->v_top * static_cast<double>(speeds) - 1;
    const double y = (a / place->a_top + 1) / 2 * static_cast<double>(accelerations - 1);
    if (!(x >= 0 && x <= static_cast<double>(speeds - 1) && y >= 0 && y <= static_cast<double>(accelerations - 1)))
      return HUGE_VAL;
    const std::size_t n = std::min(speeds - 2, static_cast<std::size_t>(x)),
                      m = std::min(accelerations - 2, static_cast<std::size_t>(y));
    const double fx = x - static_cast<double>(n), fy = y - static_cast<double>(m);
    double sum = 0, weights = 0;
    for (const std::size_t i : {0, 1})
      for (const std::size_t j : {0, 1}) {
        const double w = (i == 1 ? fx : 1 - fx) * (j == 1 ? fy : 1 - fy), value = t[(n + i) * accelerations + m + j];
        if (value < HUGE_VAL) sum += w * value, weights += w;
      }
    return weights > 0.25 ? sum / weights : HUGE_VAL;
  }
};

/// Seconds for `mm` from speed v and acceleration a at jerk j; infinite where it does not come so far.
double seconds_for(double mm, double v, double a, double j) {
  double t = mm / v;
  for (int n = 0; n < 30; ++n) {
    const double speed = v + t * (a + t * j / 2), off = t * (v + t * (a / 2 + t * j / 6)) - mm;
    if (!(speed > 0)) return HUGE_VAL;
    t -= off / speed;
    if (!(t > 0)) return HUGE_VAL;
    if (std::abs(off) < 1e-10 * mm) return t;
  }
  return HUGE_VAL;
}

}  // namespace

double optimum_s(std::span<const motion::Curve> curves, const motion::Limits& limits, const OptimumGrid& grid) {
  const Path path(curves, limits);
  const std::vector<GridPlace> at = places(path, grid.place_s);
  const double end_mm = path.length() - at.back().s;
  Times after{grid.speeds, grid.accelerations, &at.back(), std::vector<double>(grid.speeds * grid.accelerations)};
  for (std::size_t n = 0; n < grid.speeds; ++n)
    for (std::size_t m = 0; m < grid.accelerations; ++m) after.t[n * grid.accelerations + m] = 3 * end_mm / after.v(n);
  for (std::size_t k = at.size() - 1; k-- > 0;) {
    Times here{grid.speeds, grid.accelerations, &at[k], std::vector<double>(after.t.size(), HUGE_VAL)};
    const double mm = at[k + 1].s - at[k].s;
    for (std::size_t n = 0; n < grid.speeds; ++n)
      for (std::size_t m = 0; m < grid.accelerations; ++m) {
        const double v = here.v(n), a = here.a(m);
        if (!path.allowed(at[k].q, v, a)) continue;
        const auto [low, high] = path.jerks(at[k].q, v, a);
        if (!(low <= high)) continue;
        double& best = here.t[n * grid.accelerations + m];
        for (std::size_t i = 0; i < grid.jerks; ++i) {
          const double j = low + (high - low) * static_cast<double>(i) / static_cast<double>(grid.jerks - 1);
          const double t = seconds_for(mm, v, a, j);
          if (!(t < HUGE_VAL)) continue;
          best = std::min(best, t + after.between(v + t * (a + t * j / 2), a + t * j));
        }
      }
    after = std::move(here);
  }
  const double j0 = path.jerk_along(path.at(0)), t0 = std::cbrt(6 * at.front().s / j0);
  return t0 + after.between(j0 * t0 * t0 / 2, j0 * t0);
}

}  // namespace gantry::bench
