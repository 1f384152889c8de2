// Judges of a profile that share nothing with the planner: re-integration in long double, and a search for anything
// shorter on grids of switching times.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "motion/profile/planner.hpp"

namespace gantry::motion::judge {

struct Integrated {
  long double p, v, a;
  long double v_top, a_top, j_top;  ///< largest magnitudes met, inside phases too
  long double v_high, v_low, a_high, a_low, j_high, j_low, p_high, p_low;  ///< met
  long double duration;
};

inline Integrated integrate(const Profile& profile) {
  Integrated x{};
  x.p = x.p_high = x.p_low = profile.from.p;
  x.v = x.v_high = x.v_low = profile.from.v;
  x.a = x.a_high = x.a_low = profile.from.a;
  const auto meet = [](long double value, long double& high, long double& low) {
    high = std::max(high, value), low = std::min(low, value);
  };
  for (const Phase& phase : profile.phases) {
    const long double t = phase.duration_s, j = phase.jerk;
    const auto p_at = [&](long double u) { return x.p + u * x.v + u * u * x.a / 2 + u * u * u * j / 6; };
    const auto v_at = [&](long double u) { return x.v + u * x.a + u * u * j / 2; };
    // Where the acceleration is 0 the speed has its extreme; where the speed is 0 the position has.
    if (j != 0 && -x.a / j > 0 && -x.a / j < t) meet(v_at(-x.a / j), x.v_high, x.v_low);
    for (int i = 1; i < 64; ++i) {
      long double lo = t * (i - 1) / 63, hi = t * i / 63;
      if ((v_at(lo) < 0) == (v_at(hi) < 0)) continue;
      const bool below = v_at(lo) < 0;
      for (int k = 0; k < 64; ++k) {
        const long double mid = (lo + hi) / 2;
        ((v_at(mid) < 0) == below ? lo : hi) = mid;
      }
      meet(p_at(lo), x.p_high, x.p_low);
    }
    x.p = p_at(t);
    x.v = v_at(t);
    x.a += t * j;
    meet(x.p, x.p_high, x.p_low);
    meet(x.v, x.v_high, x.v_low);
    meet(x.a, x.a_high, x.a_low);
    meet(j, x.j_high, x.j_low);
    x.duration += t;
  }
  x.v_top = std::max(x.v_high, -x.v_low), x.a_top = std::max(x.a_high, -x.a_low);
  x.j_top = std::max(x.j_high, -x.j_low);
  return x;
}

/// "" when the profile is right, else what is wrong with it.
inline std::string verdict(const Profile& profile, const State& from, const State& to, const AxisBounds& b) {
  for (const Phase& phase : profile.phases)
    if (!(phase.duration_s >= 0) || !std::isfinite(phase.duration_s))
      return "a phase's duration is negative or no number";
  if (profile.from.p != from.p || profile.from.v != from.v || profile.from.a != from.a) return "starts elsewhere";
  const Integrated x = integrate(profile);
  const double v = std::max(b.v_max, -b.v_min), a = std::max(b.a_max, -b.a_min);
  const double scale = std::max({std::abs(from.p), std::abs(to.p), v * v / a});
  const auto off = [](const char* what, long double by) { return what + std::to_string((double)by); };
  if (!(std::abs(x.p - to.p) <= 1e-9 * scale)) return off("misses p by ", (x.p - to.p) / scale);
  if (!(std::abs(x.v - to.v) <= 1e-9 * v)) return off("misses v by ", (x.v - to.v) / v);
  if (!(std::abs(x.a - to.a) <= 1e-9 * a)) return off("misses a by ", (x.a - to.a) / a);
  const double more = 1 + 1e-9;
  if (!(x.v_high <= b.v_max * more && x.v_low >= b.v_min * more)) return off("speed up to ", x.v_top);
  if (!(x.a_high <= b.a_max * more && x.a_low >= b.a_min * more)) return off("acceleration up to ", x.a_top);
  if (!(x.j_high <= b.j_max * more && x.j_low >= b.j_min * more)) return off("jerk up to ", x.j_top);
  if (!(x.p_high <= b.p_max + 1e-9 * scale && x.p_low >= b.p_min - 1e-9 * scale)) return "leaves the position limits";
  return "";
}

/// A speed bound also needs room for what the acceleration will do, or has done.
inline bool tenable(const State& x, const AxisBounds& b, double time_sign) {
  const double jerk = (x.a > 0) == (time_sign > 0) ? -b.j_min : b.j_max;
  const double other = x.v + time_sign * x.a * std::abs(x.a) / (2 * jerk);
  const auto inside = [&](double v) { return v <= b.v_max && v >= b.v_min; };
  return inside(x.v) && inside(other) && x.a <= b.a_max && x.a >= b.a_min;
}

/// Shortest duration found by trying motions of the shape s(+ 0 - 0 - 0 +), s = +1 and -1, with the first switching
/// time on a grid, the second solved for the end speed on a grid, and each bracket of the end position bisected. Knows
/// no closed form but the speed after two ramps.
class Search {
 public:
  Search(const State& from, const State& to, const AxisBounds& b, int grid)
      : from_(from), to_(to), b_(b), grid_(grid) {}

  long double shortest() {
    for (const long double sign : {1.0L, -1.0L}) family(sign);
    return best_;
  }

 private:
  struct Trial {
    long double p = 0, duration = std::numeric_limits<long double>::infinity();
    bool valid = false;
  };
  struct Moving {
    long double p, v, a, t;
    void go(long double j, long double dt) {
      p += dt * (v + dt * (a / 2 + dt * j / 6));
      v += dt * (a + dt * j / 2);
      a += dt * j;
      t += dt;
    }
  };

  [[nodiscard]] long double jerk(long double s) const { return s > 0 ? b_.j_max : -b_.j_min; }
  [[nodiscard]] long double most_a(long double s) const { return s > 0 ? b_.a_max : -b_.a_min; }
  [[nodiscard]] long double most_v(long double s) const { return s > 0 ? b_.v_max : -b_.v_min; }
  [[nodiscard]] long double slowest() const {  // of any ramp, with time to spare
    const long double a = std::min(b_.a_max, -b_.a_min), v = std::max(b_.v_max, -b_.v_min);
    return 2 * std::max(b_.a_max, -b_.a_min) / std::min(b_.j_max, -b_.j_min) + 3 * v / a;
  }

  /// Jerk s for x, with the acceleration held once it has reached the bound.
  void ramp(Moving& m, long double s, long double x) const {
    const long double free = std::max((most_a(s) - s * m.a) / jerk(s), 0.0L);
    m.go(s * jerk(s), std::min(x, free));
    if (x > free) m.go(0, x - free);
  }
  void close(Moving& m, long double s) const { m.go(s * jerk(s), std::max((to_.a - m.a) / (s * jerk(s)), 0.0L)); }

  /// First ramp x; then all second ramps that bring the end speed right.
  std::vector<Trial> trials(long double s, long double x) const {
    std::vector<Trial> out;
    Moving first{from_.p, from_.v, from_.a, 0};
    ramp(first, s, x);
    const auto miss = [&](long double y) {
      Moving m = first;
      ramp(m, -s, y);
      if (s * (to_.a - m.a) < -1e-12L * most_a(s)) return std::numeric_limits<long double>::quiet_NaN();
      close(m, s);
      return m.v - to_.v;
    };
    const long double begin = std::max(s * (first.a - to_.a) / jerk(-s), 0.0L);
    const long double span = slowest() + 1e-9L;
    long double y0 = begin, f0 = miss(y0);
    for (int i = 1; i <= grid_; ++i) {
      const long double y1 = begin + span * i / grid_, f1 = miss(y1);
      if ((f0 < 0) != (f1 < 0) && std::isfinite(f0) && std::isfinite(f1)) {
        long double lo = y0, hi = y1;
        for (int k = 0; k < 70; ++k) {
          const long double mid = (lo + hi) / 2;
          ((miss(mid) < 0) == (f0 < 0) ? lo : hi) = mid;
        }
        Moving m = first;
        const long double crossing = s * first.a > 0 ? s * first.a / jerk(-s) : 0;
        Moving top = first;
        top.go(-s * jerk(-s), std::min(crossing, lo));
        ramp(m, -s, lo);
        close(m, s);
        out.push_back({m.p, m.t, top.v <= b_.v_max * (1 + 1e-12L) && top.v >= b_.v_min * (1 + 1e-12L)});
      }
      y0 = y1, f0 = f1;
    }
    return out;
  }

  void take(const Trial& t) {
    if (t.valid && std::abs(t.p - to_.p) <=
                       1e-10L * std::max({std::abs(from_.p), std::abs(to_.p), b_.v_max * b_.v_max / b_.a_max}))
      best_ = std::min(best_, t.duration);
  }

  void family(long double s) {
    const long double span = slowest();
    std::vector<Trial> last = trials(s, 0);
    for (int i = 1; i <= grid_; ++i) {
      const long double x0 = span * (i - 1) / grid_, x1 = span * i / grid_;
      const std::vector<Trial> now = trials(s, x1);
      if (now.size() == last.size())
        for (std::size_t k = 0; k < now.size(); ++k) {
          if ((last[k].p < to_.p) == (now[k].p < to_.p)) continue;
          long double lo = x0, hi = x1;
          Trial found;
          for (int n = 0; n < 60; ++n) {
            const long double mid = (lo + hi) / 2;
            const auto t = trials(s, mid);
            if (t.size() != now.size()) break;
            found = t[k];
            ((found.p < to_.p) == (last[k].p < to_.p) ? lo : hi) = mid;
          }
          take(found);
        }
      last = now;
    }
    coast(s);
  }

  /// With an arc on the speed bound: both ends are speed changes, the rest of the distance is driven at the bound.
  void coast(long double s) {
    Moving m{from_.p, from_.v, from_.a, 0};
    if (!to_bound(m, s)) return;
    // Reversed time: same speeds, opposite acceleration, whose bounds are exchanged with it.
    Search reversed(to_, from_, b_, grid_);
    reversed.b_.a_max = -b_.a_min, reversed.b_.a_min = -b_.a_max;
    Moving back{0, to_.v, -to_.a, 0};
    if (!reversed.to_bound(back, s)) return;
    const long double rest = to_.p - m.p - back.p;
    if (s * rest >= 0) best_ = std::min(best_, m.t + back.t + s * rest / most_v(s));
  }
  bool to_bound(Moving& m, long double s) const {
    long double lo = 0, hi = slowest();
    const auto after = [&](long double x) {
      Moving n = m;
      ramp(n, s, x);
      n.go(-s * jerk(-s), std::max(s * n.a / jerk(-s), 0.0L));
      return n;
    };
    if (s * m.a < 0) lo = -s * m.a / jerk(s);
    if (s * after(lo).v > most_v(s)) return false;
    for (int k = 0; k < 80; ++k) {
      const long double mid = (lo + hi) / 2;
      (s * after(mid).v > most_v(s) ? hi : lo) = mid;
    }
    m = after(lo);
    return true;
  }

  State from_, to_;
  AxisBounds b_;
  int grid_;
  long double best_ = std::numeric_limits<long double>::infinity();
};

}  // namespace gantry::motion::judge
