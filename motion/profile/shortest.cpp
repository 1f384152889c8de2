// Shortest profile between two states, in scaled units.
//
// Pontryagin: jerk is +1, 0, -1, 0, -1, 0, +1 (family "up") or its mirror ("down"); zeros are arcs on a bound. Without
// the speed arc, "up" rises from a0 to a peak aP (held for tP when aP = 1), falls to a low aL (held for tL when aL =
// -1) and rises to af. The speed condition alone gives
//   aP^2 + tP = D + aL^2 + tL,   D = (vf - v0) - (af^2 - a0^2)/2,
// a one-parameter family. For D >= 0 the parameter is x = -aL (beyond 1: x = 1 + tL), for then aP = sqrt(D + x^2 ...)
// always exists; D < 0 is the same problem in reversed time: (vf, -af) -> (v0, -a0), same way p. Duration grows with x.
// Along the family dp/dT = H, the Hamiltonian of the shortest motion, H = (speed where the fall begins) + aP w/2, w =
// the fall's duration; so dp/dx = H dT/dx in closed form, and p(x) is monotone between zeros of H. aP >= a0 cuts a hole
// |x| < sqrt(a0^2 - D) into the family when a0^2 > D and a0 > 0: durations at which the end state cannot be met
// ("blocked"); af >= aL sets its beginning, x >= -af; the peak speed vf - af^2/2 + x^2 + tL <= v_max its end, beyond
// which only the coasting grows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/profile/scaled.hpp"

namespace gantry::motion::scaled {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

double length(const Problem& q, const Shape& s) noexcept {
  double p = 0, v = q.v0, a = q.a0;
  for (int i = 0; i < 7; ++i) {
    const double t = s.t[i], j = kJerk[i];
    p += t * (v + t * (a / 2 + t * j / 6));
    v += t * (a + t * j / 2);
    a += t * j;
  }
  return p;
}

/// The family "up" of a problem with D >= 0, and how p and T change along it.
struct Up {
  const Problem& q;
  double d;  // D

  [[nodiscard]] Shape at(double x) const noexcept {
    const double low = std::min(x, 1.0), hold = std::max(x - 1, 0.0);
    const double g = d + (x < 1 ? x * x : x), top = peak(x);
    Shape s;
    s.t[0] = std::max(top - q.a0, 0.0);
    s.t[1] = std::max(g - 1, 0.0);
    s.t[2] = low >= 0 ? top : std::max(top + low, 0.0);  // one fall of peak + low, split where a = 0
    s.t[4] = std::max(low, 0.0);
    s.t[5] = hold;
    s.t[6] = std::max(q.af + low, 0.0);
    return s;
  }

  [[nodiscard]] double peak(double x) const noexcept {
    const double g = d + (x < 1 ? x * x : x);
    return g < 1 ? std::sqrt(g) : 1.0;
  }

  /// dp/dT.
  [[nodiscard]] double hamiltonian(double x) const noexcept {
    const double g = d + (x < 1 ? x * x : x), top = peak(x);
    const double v_fall = q.v0 - q.a0 * q.a0 / 2 + top * top / 2 + std::max(g - 1, 0.0);
    return v_fall + top * (top + std::min(x, 1.0)) / 2;
  }

  /// dp/dx. Beyond x = 1 both bounds are reached (g = D + x >= 1).
  [[nodiscard]] double slope(double x) const noexcept {
    const double top = peak(x);
    const double dt = x >= 1 ? 2 : 2 + 2 * (top < 1 ? (top > 0 ? x / top : 1.0) : x);
    return hamiltonian(x) * dt;
  }
};

struct Search {
  bool found = false;
  Shape shape;
  double nearest_miss = std::numeric_limits<double>::infinity();  // of a family's beginning: rounding may leave a gap
  Shape nearest;
};

void offer(Search& search, const Shape& s) noexcept {
  if (!search.found || s.duration() < search.shape.duration()) {
    search.found = true;
    search.shape = s;
  }
}

/// Root of length(at(x)) = p within [lo, hi], where it changes sign: Newton, kept inside the bracket.
double root(const Up& up, double lo, double hi, double f_lo) noexcept {
  const double tolerance = kEps * std::abs(up.q.p);
  double x = (lo + hi) / 2;
  for (int i = 0; i < 80; ++i) {
    const double f = length(up.q, up.at(x)) - up.q.p;
    if (std::abs(f) <= tolerance) break;
    if ((f < 0) == (f_lo < 0))
      lo = x;
    else
      hi = x;
    double next = x - f / up.slope(x);
    if (!(next > lo && next < hi)) next = (lo + hi) / 2;
    if (std::abs(next - x) <= kEps * std::abs(next)) break;
    x = next;
  }
  return x;
}

/// Parameters in x < 0 at which dp/dx changes its sign; there H need not be monotone.
int turning_points(const Up& up, double* out) noexcept {
  int n = 0;
  // peak below 1, w = peak + x, peak = (w + D/w)/2:  H = c + 3 w^2/8 + D^2/(8 w^2) = 0, a quadratic in w^2.
  const double c = up.q.v0 - up.q.a0 * up.q.a0 / 2 + up.d / 2;
  const double disc = 16 * c * c - 3 * up.d * up.d;
  if (c < 0 && disc >= 0) {
    for (const double sign : {-1.0, 1.0}) {
      const double z = (-4 * c + sign * std::sqrt(disc)) / 3;
      if (z > 0) out[n++] = (std::sqrt(z) - up.d / std::sqrt(z)) / 2;
    }
  }
  // peak at 1:  H = v0 + (1 - a0^2)/2 + D + x^2 - 1 + (1 + x)/2 = 0.
  const double k = 1.0 / 16 - (up.q.v0 + (1 - up.q.a0 * up.q.a0) / 2 + up.d - 0.5);
  if (k >= 0) {
    out[n++] = -0.25 - std::sqrt(k);
    out[n++] = -0.25 + std::sqrt(k);
  }
  return n;
}

/// Drops what is not inside (begin, end) and sorts the rest; returns how many stay.
int keep_sorted(double* x, int n, double begin, double end) noexcept {
  int kept = 0;
  for (int i = 0; i < n; ++i) {
    const double value = x[i];
    if (!(value > begin && value < end)) continue;
    int k = kept++;
    for (; k > 0 && x[k - 1] > value; --k) x[k] = x[k - 1];
    x[k] = value;
  }
  return kept;
}

/// What D is uncertain by.
double rounding(const Problem& q) noexcept {
  return 8 * kEps * (std::abs(q.v0) + std::abs(q.vf) + q.a0 * q.a0 + q.af * q.af);
}

/// First root in [begin, end]; true when there is one. `blur`: what p is uncertain by at edges of the family.
bool scan(const Up& up, double begin, double end, double blur, Search& search) noexcept {
  const Problem& q = up.q;
  const Shape first = up.at(begin);
  double f = length(q, first) - q.p;
  if (std::abs(f) < search.nearest_miss) {
    search.nearest_miss = std::abs(f);
    search.nearest = first;
  }
  if (std::abs(f) <= blur) {
    offer(search, first);
    return true;
  }
  double knots[8];
  int n = 0;
  if (begin < 0) n = turning_points(up, knots);
  if (up.d < 1) {
    knots[n++] = -std::sqrt(1 - up.d);
    knots[n++] = std::sqrt(1 - up.d);
  }
  knots[n++] = 1;
  n = keep_sorted(knots, n, begin, end);
  knots[n++] = end;
  double x = begin;
  for (int i = 0; i < n; ++i) {
    const double f_next = length(q, up.at(knots[i])) - q.p;
    if ((f < 0) != (f_next < 0) || f_next == 0) {
      offer(search, up.at(root(up, x, knots[i], f)));
      return true;
    }
    x = knots[i];
    f = f_next;
  }
  if (std::abs(f) > blur) return false;
  offer(search, up.at(end));
  return true;
}

/// All of "up" for D >= 0.
void search_up(const Problem& q, double d, Search& search) noexcept {
  const Up up{q, d};
  // Where the family begins, p is as uncertain as D makes the peak (dp = H dD / peak) and the hole's edge.
  const double unsure = rounding(q), hole_2 = q.a0 > 0 ? q.a0 * q.a0 - d : 0;
  const auto blur = [&](double x, double edge) {
    const double of_peak = std::abs(up.hamiltonian(x)) * std::min(std::sqrt(unsure), unsure / up.peak(x));
    return q.resolution + std::min(of_peak + std::abs(up.slope(x)) * edge, 4000 * q.resolution);
  };
  double begin = -q.af, edge = 0;
  if (hole_2 > unsure) {
    const double hole = std::sqrt(hole_2);
    edge = unsure / (2 * hole);
    if (begin < -hole && scan(up, begin, -hole, std::max(blur(begin, 0), blur(-hole, edge)), search)) return;
    begin = std::max(begin, hole);
  }
  const double room = std::max(q.v_max - (q.vf - q.af * q.af / 2), 0.0);  // for x^2 + tL
  const double end = std::max(room < 1 ? std::sqrt(room) : room, begin);
  if (scan(up, begin, end, blur(begin, edge), search)) return;
  Shape s = up.at(end);
  const double rest = q.p - length(q, s);
  if (rest < 0) return;
  s.t[3] = rest / q.v_max;
  offer(search, s);
}

/// "up" in reversed time: the same way from (vf, -af) to (v0, -a0).
void search_back(const Problem& q, double d, Search& search) noexcept {
  Problem back = q;
  back.v0 = q.vf, back.a0 = -q.af, back.vf = q.v0, back.af = -q.a0;
  Search found;
  search_up(back, d, found);
  std::reverse(found.shape.t, found.shape.t + 7);
  std::reverse(found.nearest.t, found.nearest.t + 7);
  if (found.found) offer(search, found.shape);
  if (found.nearest_miss < search.nearest_miss) {
    search.nearest_miss = found.nearest_miss;
    search.nearest = found.nearest;
  }
}

/// "up" of any problem. At D = 0 (one ramp can do) rounding must not decide: both are tried.
void search_family(const Problem& q, Search& search) noexcept {
  const double d = (q.vf - q.v0) - (q.af * q.af - q.a0 * q.a0) / 2;
  const double unsure = rounding(q);
  if (d >= -unsure) search_up(q, std::max(d, 0.0), search);
  if (d <= unsure) search_back(q, std::max(-d, 0.0), search);
}

}  // namespace

bool shortest(const Problem& problem, Shape& best) noexcept {
  Problem mirror = problem;
  mirror.v0 = -problem.v0, mirror.a0 = -problem.a0, mirror.vf = -problem.vf, mirror.af = -problem.af;
  mirror.p = -problem.p;
  Search up, down;
  search_family(problem, up);
  search_family(mirror, down);
  down.shape.sign = down.nearest.sign = -1;
  if (up.found && (!down.found || up.shape.duration() <= down.shape.duration())) {
    best = up.shape;
  } else if (down.found) {
    best = down.shape;
  } else {
    // Both families begin at the same motion; p within rounding of it can fall between them.
    best = up.nearest_miss <= down.nearest_miss ? up.nearest : down.nearest;
  }
  return std::isfinite(best.duration());
}

}  // namespace gantry::motion::scaled
