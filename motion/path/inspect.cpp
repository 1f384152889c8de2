// The integrator: it takes the pieces as they are, integrates them from the state before, and differentiates the axes'
// motion by truncated power series in time (x(t0 + e) to e^3), not by the formulas of the planner.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "motion/path/series.hpp"
#include "motion/path/timing.hpp"

namespace gantry::motion {
namespace {

constexpr double kNearly = 1 - 1e-12;  ///< by more than what a root is rounded by

/// Motion of one axis around the moment at which s is as given: value, speed, acceleration, jerk. `degree`: powers of u
/// behind it are not in the curve.
Series axis_motion(const Curve& g, const Series& u, std::size_t axis, std::size_t degree = 3) {
  const Series q = polynomial([&](std::size_t k) { return g.c[k][axis]; }, degree, u);
  return {q[0], q[1], 2 * q[2], 6 * q[3]};
}

/// The highest power whose coefficient is not 0: what is 0 need not be multiplied.
template <class Coefficients>
std::size_t degree_of(const Coefficients& c, std::size_t most) {
  while (most > 0 && c(most) == 0) --most;
  return most;
}

/// Of a curve: of u in the length, and of each axis in u; 0 for an axis that stands.
struct Degrees {
  Degrees(const Curve& g, std::size_t axes) : u(degree_of([&](std::size_t k) { return g.u[k]; }, 5)) {
    for (std::size_t i = 0; i < axes; ++i) axis[i] = degree_of([&](std::size_t k) { return g.c[k][i]; }, 3);
  }
  std::size_t u;
  std::array<std::size_t, kMaxAxes> axis{};
};

/// Position, direction and curvature at the end of one and the beginning of the other.
bool join(const Curve& a, const Curve& b, std::size_t axes) {
  const auto around = [](const Curve& g, double x, std::size_t axis) {
    const Series u = polynomial([&](std::size_t k) { return g.u[k]; }, 5, {x, 1 / g.length, 0, 0});
    return axis_motion(g, u, axis);
  };
  const double short_one = std::min(a.length, b.length);
  for (std::size_t i = 0; i < axes; ++i) {
    const Series x = around(a, 1, i), y = around(b, 0, i);
    const double rounding = 1e-14 * (std::abs(x[0]) + 1);
    if (std::abs(x[0] - y[0]) > 1e-9) return false;
    if (a.rest_after) continue;
    if (std::abs(x[1] - y[1]) > 1e-6 * (1 + std::abs(x[1])) + rounding / short_one) return false;
    if (std::abs(x[2] - y[2]) > 1e-4 * (std::abs(x[2]) + 1e-2 / short_one) + rounding / (short_one * short_one))
      return false;
  }
  return true;
}

}  // namespace

Inspection inspect(const Stretch& stretch, const Limits& limits, double v_set, const State& from) {
  Inspection out;
  const auto refuse = [&](const char* what, double where, double value) {
    char text[160];
    std::snprintf(text, sizeof text, "%s at s = %.9g of %.9g: %.9g", what, where, stretch.length_mm, value);
    out.reason = text;
    out.sound = false;
    return out;
  };
  double length = 0;
  std::vector<Degrees> degrees_of;
  for (std::size_t k = 0; k < stretch.curves.size(); ++k) {
    if (k > 0 && !join(stretch.curves[k - 1], stretch.curves[k], limits.axes))
      return refuse("curves that do not join smoothly", length, static_cast<double>(k));
    length += stretch.curves[k].length;
    degrees_of.emplace_back(stretch.curves[k], limits.axes);
  }
  const double close = 1e-9 * std::max(1.0, length);

  State x = from;
  x.p = 0;
  std::size_t curve = 0;
  double begin = 0;
  bool gentle_enough = true;
  for (const TimePiece& p : stretch.pieces) {
    if (!(p.duration_s > 0) || !std::isfinite(p.duration_s + p.j))
      return refuse("a piece without duration", p.s, p.duration_s);
    if (std::abs(p.s - x.p) > close) return refuse("pieces that do not join", p.s, p.s - x.p);
    const double v_scale = std::max({std::abs(x.v), std::abs(p.a) * p.duration_s, 1e-9});
    if (std::abs(p.v - x.v) > 1e-7 * v_scale + 1e-9) return refuse("a jump of speed", p.s, p.v - x.v);
    if (std::abs(p.a - x.a) > 1e-6 * (std::abs(p.a) + std::abs(p.j) * p.duration_s) + 1e-6)
      return refuse("a jump of acceleration", p.s, p.a - x.a);
    constexpr int kSamples = 4;
    // A piece lies on one curve, that of its middle; q''' may jump at the joints.
    const double half = p.duration_s / 2, middle = x.p + half * (x.v + half * (x.a / 2 + half * p.j / 6));
    while (curve + 1 < stretch.curves.size() && middle > begin + stretch.curves[curve].length)
      begin += stretch.curves[curve++].length;
    double& piece = out.piece_share.emplace_back(0);
    if (const double peak = p.j != 0 ? -x.a / p.j : 0; peak > 0 && peak < p.duration_s)
      piece = std::max(piece, (x.v + peak * x.a / 2) / v_set);
    for (int n = 0; n <= kSamples; ++n) {
      const double t = p.duration_s * n / kSamples;
      const State y{x.p + t * (x.v + t * (x.a / 2 + t * p.j / 6)), x.v + t * (x.a + t * p.j / 2), x.a + t * p.j};
      if (!(y.v >= -1e-9 * v_scale)) return refuse("backwards", y.p, y.v);
      if (!(y.p >= -close && y.p <= length + close)) return refuse("beyond the path", y.p, y.p - length);
      const Curve& g = stretch.curves[curve];
      const Degrees& degrees = degrees_of[curve];
      const Series xs{(y.p - begin) / g.length, y.v / g.length, y.a / (2 * g.length), p.j / (6 * g.length)};
      const Series u = polynomial([&](std::size_t k) { return g.u[k]; }, degrees.u, xs);
      piece = std::max(piece, y.v / v_set);
      for (std::size_t i = 0; i < limits.axes; ++i) {
        if (degrees.axis[i] == 0) continue;
        const Series q = axis_motion(g, u, i, degrees.axis[i]);
        const AxisLimits& l = limits.axis[i];
        piece = std::max(piece, std::abs(q[1]) / l.v_max);
        // Roots are taken only where they may be larger than what was found.
        const double a = std::abs(q[2]) / l.a_max, j = std::abs(q[3]) / l.j_max;
        if (a > kNearly * piece * piece) piece = std::max(piece, std::sqrt(a));
        if (j > kNearly * piece * piece * piece) piece = std::max(piece, std::cbrt(j));
        const bool slow = std::abs(q[1]) <= 1.001 * l.v_max;
        const bool gentle = std::abs(q[2]) <= 1.001 * l.a_max && std::abs(q[3]) <= 1.001 * l.j_max;
        gentle_enough = gentle_enough && gentle;
        if (!(slow && gentle) && out.reason.empty()) {
          char text[200];
          std::snprintf(text, sizeof text, "axis %zu at s = %.9g of %.9g: v %.4f a %.4f j %.4f of its limits", i, y.p,
                        length, q[1] / l.v_max, q[2] / l.a_max, q[3] / l.j_max);
          out.reason = text;
        }
      }
      out.share = std::max(out.share, piece);
      if (n == kSamples) x = y;
    }
  }
  if (std::abs(x.p - length) > close) return refuse("an end that is not the path's", x.p, x.p - length);
  out.sound = out.reason.empty() && out.share <= 1.001;
  out.only_speed = !out.sound && gentle_enough;
  if (!out.sound && out.reason.empty()) out.reason = "the set speed is exceeded";
  return out;
}

}  // namespace gantry::motion
