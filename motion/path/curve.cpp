#include "motion/path/curve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "motion/path/gauss.hpp"

namespace gantry::motion {
namespace {

constexpr double kMapError = 2e-4;  ///< of speed along a piece: |dq/ds| - 1
// A ripple e in |dq/ds| is one of about 36 e / length^2 in q'''; it stays below this share of q''' (and 1e-4 / mm^2).
constexpr double kRippleShare = 0.01, kRipple = 1e-4;
constexpr int kMostSplits = 14;

AxisVec mean(const AxisVec& a, const AxisVec& b) {
  AxisVec out{};
  for (std::size_t i = 0; i < kMaxAxes; ++i) out[i] = (a[i] + b[i]) / 2;
  return out;
}

/// Speed |dq/du| and its derivative by u.
struct Rate {
  double value = 0, slope = 0;
};

Rate rate(const Measure& m, const Curve& g, double u) {
  double first = 0, mixed = 0;
  for (std::size_t i = 0; i < m.axes; ++i) {
    if (!m.along[i]) continue;
    const double d1 = g.c[1][i] + u * (2 * g.c[2][i] + u * 3 * g.c[3][i]);
    const double d2 = 2 * g.c[2][i] + u * 6 * g.c[3][i];
    first += d1 * d1;
    mixed += d1 * d2;
  }
  first = std::sqrt(first);
  return {first, mixed / first};
}

double length_of(const Measure& m, const Curve& g) {
  return integral([&](double u) { return rate(m, g, u).value; });
}

// u(x) of fifth degree, x = s/length: u, u', u'' as arc length has them at both ends: with r = |dq/du|,
//   du/dx = length / r,   d2u/dx2 = -length^2 r' / r^3.
void map_arc_length(const Measure& m, Curve& g) {
  const Rate r0 = rate(m, g, 0), r1 = rate(m, g, 1);
  const double l = g.length;
  const double p = l / r0.value, q = l / r1.value;
  const double pp = -l * l * r0.slope / (r0.value * r0.value * r0.value);
  const double qq = -l * l * r1.slope / (r1.value * r1.value * r1.value);
  // What is left to do at x = 1 after the terms up to x^2.
  const double e0 = 1 - p - pp / 2, e1 = q - p - pp, e2 = qq - pp;
  g.u = {0, p, pp / 2, 10 * e0 - 4 * e1 + e2 / 2, -15 * e0 + 7 * e1 - e2, 6 * e0 - 3 * e1 + e2 / 2};
}

bool carries_arc_length(const Measure& m, const Curve& g) {
  double third = 0;
  for (const double at : {0.0, 0.5, 1.0}) third = std::max(third, along(m, jet(g, at * g.length, m.axes).d3));
  const double most = std::min(kMapError, std::max(kRippleShare * third, kRipple) * g.length * g.length / 36);
  for (int k = 1; k < 8; ++k) {
    const double x = k / 8.0;
    double u = 0, slope = 0;
    for (std::size_t n = 6; n-- > 0;) {
      slope = slope * x + u;
      u = u * x + g.u[n];
    }
    if (!(std::abs(rate(m, g, u).value * slope / g.length - 1) <= most)) return false;
  }
  return true;
}

void append(const Measure& m, const std::array<AxisVec, 4>& b, std::uint16_t cells, int splits,
            std::vector<Curve>& out) {
  Curve g;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    g.c[0][i] = b[0][i];
    g.c[1][i] = 3 * (b[1][i] - b[0][i]);
    g.c[2][i] = 3 * (b[2][i] - 2 * b[1][i] + b[0][i]);
    g.c[3][i] = b[3][i] - b[0][i] - 3 * (b[2][i] - b[1][i]);  // exactly 0 where all are equal
  }
  g.cells = cells;
  g.length = length_of(m, g);
  map_arc_length(m, g);
  if (splits >= kMostSplits || carries_arc_length(m, g)) {
    out.push_back(g);
    return;
  }
  const AxisVec b01 = mean(b[0], b[1]), b12 = mean(b[1], b[2]), b23 = mean(b[2], b[3]);
  const AxisVec b012 = mean(b01, b12), b123 = mean(b12, b23), middle = mean(b012, b123);
  const auto half = static_cast<std::uint16_t>(std::max(2, cells / 2));
  append(m, {b[0], b01, b012, middle}, half, splits + 1, out);
  append(m, {middle, b123, b23, b[3]}, half, splits + 1, out);
}

}  // namespace

double along(const Measure& m, const AxisVec& displacement) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < m.axes; ++i)
    if (m.along[i]) sum += displacement[i] * displacement[i];
  return std::sqrt(sum);
}

double aside(const Measure& m, const AxisVec& displacement) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < m.axes; ++i) {
    const double x = m.weight[i] * displacement[i];
    sum += x * x;
  }
  return std::sqrt(sum);
}

// With x = s/length:  dq/ds = q_u u',  d2q/ds2 = q_uu u'^2 + q_u u'',  d3q/ds3 = q_uuu u'^3 + 3 q_uu u' u'' + q_u u'''.
CurveJet jet(const Curve& g, double s, std::size_t axes) noexcept {
  CurveJet out;
  const double per_mm = 1 / g.length, x = s * per_mm;
  if (g.straight) {
    for (std::size_t i = 0; i < axes; ++i) {
      out.q[i] = g.c[0][i] + g.c[1][i] * x;
      out.d1[i] = g.c[1][i] * per_mm;
    }
    return out;
  }
  const auto& a = g.u;
  const double u = x * (a[1] + x * (a[2] + x * (a[3] + x * (a[4] + x * a[5]))));
  const double u1 = per_mm * (a[1] + x * (2 * a[2] + x * (3 * a[3] + x * (4 * a[4] + x * 5 * a[5]))));
  const double u2 = per_mm * per_mm * (2 * a[2] + x * (6 * a[3] + x * (12 * a[4] + x * 20 * a[5])));
  const double u3 = per_mm * per_mm * per_mm * (6 * a[3] + x * (24 * a[4] + x * 60 * a[5]));
  for (std::size_t i = 0; i < axes; ++i) {
    const double c1 = g.c[1][i], c2 = g.c[2][i], c3 = g.c[3][i];
    const double q1 = c1 + u * (2 * c2 + u * 3 * c3), q2 = 2 * c2 + u * 6 * c3, q3 = 6 * c3;
    out.q[i] = g.c[0][i] + u * (c1 + u * (c2 + u * c3));
    out.d1[i] = q1 * u1;
    out.d2[i] = q2 * u1 * u1 + q1 * u2;
    out.d3[i] = q3 * u1 * u1 * u1 + 3 * q2 * u1 * u2 + q1 * u3;
  }
  return out;
}

Curve straight_curve(const Measure& m, const AxisVec& from, const AxisVec& to) noexcept {
  Curve g;
  g.straight = true;
  g.c[0] = from;
  for (std::size_t i = 0; i < kMaxAxes; ++i) g.c[1][i] = to[i] - from[i];
  g.length = along(m, g.c[1]);
  g.u[1] = 1;
  return g;
}

double length_of(std::span<const Curve> curves) noexcept {
  double sum = 0;
  for (const Curve& c : curves) sum += c.length;
  return sum;
}

// u(x) and q(u) as Taylor polynomials about where the part begins: x = x0 + (x1 - x0) y, w = u - u(x0).
Curve part_of(const Curve& whole, double from, double to) noexcept {
  Curve part = whole;
  part.length = to - from;
  const double x0 = from / whole.length, share = part.length / whole.length;
  part.u = {};
  double power = 1;
  constexpr std::size_t kDegree = 5;
  for (std::size_t k = 0; k <= kDegree; ++k, power *= share) {
    double sum = 0;
    for (std::size_t n = kDegree + 1; n-- > k;) {
      double choose = 1;
      for (std::size_t i = 0; i < k; ++i) choose *= static_cast<double>(n - i) / static_cast<double>(i + 1);
      sum = sum * x0 + choose * whole.u[n];
    }
    part.u[k] = sum * power;
  }
  const double u0 = std::exchange(part.u[0], 0);
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    const double c1 = whole.c[1][i], c2 = whole.c[2][i], c3 = whole.c[3][i];
    part.c[0][i] = whole.c[0][i] + u0 * (c1 + u0 * (c2 + u0 * c3));
    part.c[1][i] = c1 + u0 * (2 * c2 + u0 * 3 * c3);
    part.c[2][i] = c2 + u0 * 3 * c3;
  }
  return part;
}

void append_curve(const Measure& m, const std::array<AxisVec, 4>& bezier, std::uint16_t cells,
                  std::vector<Curve>& out) {
  append(m, bezier, cells, 0, out);
}

}  // namespace gantry::motion
