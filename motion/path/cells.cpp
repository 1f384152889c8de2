#include "motion/path/cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gantry::motion {
namespace {

constexpr double kCellSeconds = 0.003;      ///< duration of a cell, about
constexpr double kLongCellSeconds = 0.012;  ///< where the speed surely stays
constexpr double kGrowth = 1.25;            ///< from one cell to the next, where they get longer
constexpr double kShortest = 1.0 / 16;      ///< of kCellSeconds, of a line's cells beside a curve
constexpr double kSurely = 1.3;  ///< times the speed that position allows, as soon as speeding up to it could be over

/// A place on the path at which the speed is estimated.
struct Mark {
  std::size_t curve = 0;
  double s = 0;  ///< in its curve; the mark ends an interval of that curve
  double v = 0;
};

struct Along {
  double v = 0, a = 0, j = 0;  ///< what the limits leave in the direction of the path
};

Along limits_along(const CurveJet& x, const Limits& limits, double v_set) {
  Along out{v_set, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const auto& l = limits.axis[i];
    const double q1 = std::abs(x.d1[i]), q2 = std::abs(x.d2[i]), q3 = std::abs(x.d3[i]);
    if (q1 > 0) {
      out.v = std::min(out.v, l.v_max / q1);
      out.a = std::min(out.a, l.a_max / q1);
      out.j = std::min(out.j, l.j_max / q1);
    }
    if (q2 > 0) out.v = std::min(out.v, std::sqrt(l.a_max / q2));
    if (q3 > 0) out.v = std::min(out.v, std::cbrt(l.j_max / q3));
  }
  return out;
}

// From speed v with acceleration 0, full jerk: v = v0 + j t^2/2; without v0 that is v^(3/2) = 3/2 sqrt(2 j) s. With it
// the speed is less than the sum of both laws, which is good enough here.
double grown(double v, double length, const Along& l) {
  const double by_jerk = std::pow(v * std::sqrt(v) + 1.5 * std::sqrt(2 * l.j) * length, 2.0 / 3);
  return std::min(by_jerk, std::sqrt(v * v + 2 * l.a * length));
}

/// A minimum without a kink, so that a speed which follows it needs no sudden change of acceleration.
double smooth_least(std::initializer_list<double> speeds) {
  double sum = 0;
  for (const double v : speeds) sum += 1 / (v * v * v * v);
  return 1 / std::sqrt(std::sqrt(sum));
}

/// Half of an interval between marks.
struct Half {
  double length = 0;
  double v_side = 0;   ///< speed at its slow side
  double first_s = 0;  ///< duration of its first cell
};

/// Where the cells end, from the slow side to the middle.
void march(const Half& of, double v_cap, const Along& l, bool straight, std::vector<double>& at) {
  const auto speed = [&](double x) { return std::min(v_cap, grown(of.v_side, x, l)); };
  double x = 0;
  at.clear();
  if (of.v_side <= 0) {
    const double first = l.j * kCellSeconds * kCellSeconds * kCellSeconds / 6;
    at.push_back(x = std::min(first, of.length / 20));
  }
  double cell_s = of.first_s;
  while (x < of.length) {
    double step = cell_s * speed(x);
    step = cell_s * speed(x + step / 2);
    const bool stays = straight && grown(of.v_side, x + step, l) > kSurely * v_cap;
    cell_s = std::min(kGrowth * cell_s, stays ? kLongCellSeconds : kCellSeconds);
    if (of.length - x <= 1.5 * step) break;
    at.push_back(x += step);
  }
  at.push_back(of.length);
}

// From rest at constant jerk, in units in which it is 1: a = t, v = t^2/2, s = t^3/6, v^2 = t^4/4. Cells that are long
// beside their distance from the rest get the weights of that motion; far away they are those of a small cell.
void near_rest(std::vector<PaceCell>& cells, bool at_start) {
  const std::size_t n = cells.size();
  double s = 0, t = 0;
  for (std::size_t k = 0; k < n; ++k) {
    PaceCell& c = cells[at_start ? k : n - 1 - k];
    const double t0 = t;
    s += c.length;
    t = std::cbrt(6 * s);
    if (k == 0) continue;
    if (t0 > 0.97 * t) break;
    const double cubes = t * t * t - t0 * t0 * t0, fourth = t * t * t * t - t0 * t0 * t0 * t0;
    const double weight = (0.75 * fourth / cubes - t0) / (t - t0), mean = cubes / (6 * (t - t0));
    const double near = mean / (t0 * t0 / 2), far = mean / (t * t / 2);
    c.weight = at_start ? weight : 1 - weight;
    c.mean_by_begin = at_start ? near : far;
    c.mean_by_end = at_start ? far : near;
  }
}

}  // namespace

double rough_seconds(const Curve& curve, const Limits& limits, double v_set) {
  return curve.length / limits_along(jet(curve, curve.length / 2, limits.axes), limits, v_set).v;
}

CellGrid divide(std::span<const Curve> curves, const Limits& limits, double v_set, double v0) {
  // Marks with the speed that position alone allows there.
  std::vector<Mark> marks;
  std::vector<Along> along;  // of the interval before each mark
  double cap_before = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < curves.size(); ++k) {
    const Curve& g = curves[k];
    const std::size_t parts = g.straight ? 1 : std::max<std::size_t>(g.cells, 1);
    Along begin = limits_along(jet(g, 0, limits.axes), limits, v_set);
    if (!marks.empty()) marks.back().v = std::min(cap_before, begin.v);
    for (std::size_t n = 1; n <= parts; ++n) {
      const double s = n == parts ? g.length : g.length * static_cast<double>(n) / static_cast<double>(parts);
      const Along end = limits_along(jet(g, s, limits.axes), limits, v_set);
      marks.push_back({k, s, end.v});
      along.push_back({std::max(begin.v, end.v), std::max(begin.a, end.a), std::max(begin.j, end.j)});
      begin = end;
    }
    cap_before = begin.v;
  }
  marks.back().v = 0;

  const auto length = [&](std::size_t n) {
    return n > 0 && marks[n - 1].curve == marks[n].curve ? marks[n].s - marks[n - 1].s : marks[n].s;
  };
  double v = v0;
  for (std::size_t n = 0; n < marks.size(); ++n) v = marks[n].v = std::min(marks[n].v, grown(v, length(n), along[n]));
  for (std::size_t n = marks.size() - 1; n-- > 0;)
    marks[n].v = std::min(marks[n].v, grown(marks[n + 1].v, length(n + 1), along[n + 1]));

  // A line's cells beside a curve begin as short as the curve's: a corner's change of speed goes on there.
  const auto first_s = [&](std::size_t n, std::size_t beside, double v_side) {
    const bool corner =
        v_side > 0 && beside < marks.size() && curves[marks[n].curve].straight && !curves[marks[beside].curve].straight;
    return corner ? std::clamp(length(beside) / v_side, kShortest * kCellSeconds, kCellSeconds) : kCellSeconds;
  };

  CellGrid out;
  std::vector<double> left, right, at;
  for (std::size_t n = 0; n < marks.size(); ++n) {
    const Curve& g = curves[marks[n].curve];
    const double h = length(n), begin = marks[n].s - h;
    const double v_left = n > 0 ? marks[n - 1].v : v0, v_right = marks[n].v;
    march({h / 2, v_left, first_s(n, n - 1, v_left)}, along[n].v, along[n], g.straight, left);
    march({h / 2, v_right, first_s(n, n + 1, v_right)}, along[n].v, along[n], g.straight, right);
    at = left;
    for (std::size_t i = right.size() - 1; i-- > 0;) at.push_back(h - right[i]);
    at.push_back(h);
    if (at.size() == 2 && v_left > 0 && v_right > 0) at.erase(at.begin());
    double x = 0;
    CurveJet before = jet(g, begin, limits.axes);
    for (const double y : at) {
      PaceCell c;
      c.length = y - x;
      c.straight = g.straight;
      c.v_guess = smooth_least({along[n].v, grown(v_left, y, along[n]), grown(v_right, h - y, along[n])});
      c.begin = before;
      if (!g.straight) c.middle = jet(g, begin + (x + y) / 2, limits.axes);
      c.end = before = jet(g, begin + y, limits.axes);
      out.cells.push_back(c);
      x = y;
    }
    if (n + 1 == marks.size() || marks[n + 1].curve != marks[n].curve) out.curve_end.push_back(out.cells.size());
  }
  near_rest(out.cells, false);
  if (v0 <= 0) near_rest(out.cells, true);
  return out;
}

}  // namespace gantry::motion
