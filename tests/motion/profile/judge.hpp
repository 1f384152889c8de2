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
  long double v_low;                ///< smallest speed met
  long double duration;
};

inline Integrated integrate(const Profile& profile) {
  Integrated x{profile.from.p,
               profile.from.v,
               profile.from.a,
               std::abs((long double)profile.from.v),
               std::abs((long double)profile.from.a),
               0,
               profile.from.v,
               0};
  const auto meet = [&x](long double v) {
    x.v_top = std::max(x.v_top, std::abs(v));
    x.v_low = std::min(x.v_low, v);
  };
  for (const Phase& phase : profile.phases) {
    const long double t = phase.duration_s, j = phase.jerk;
    if (j != 0) {
      const long double turn = -x.a / j;  // where the acceleration is 0, the speed has its extreme
      if (turn > 0 && turn < t) meet(x.v + x.a * turn + j * turn * turn / 2);
    }
    x.p += t * x.v + t * t * x.a / 2 + t * t * t * j / 6;
    x.v += t * x.a + t * t * j / 2;
    x.a += t * j;
    meet(x.v);
    x.a_top = std::max(x.a_top, std::abs(x.a));
    x.j_top = std::max(x.j_top, std::abs(j));
    x.duration += t;
  }
  return x;
}

/// "" when the profile is right, else what is wrong with it.
inline std::string verdict(const Profile& profile, const State& from, const State& to, const Bounds& b) {
  for (const Phase& phase : profile.phases)
    if (!(phase.duration_s >= 0) || !std::isfinite(phase.duration_s))
      return "a phase's duration is negative or no number";
  if (profile.from.p != from.p || profile.from.v != from.v || profile.from.a != from.a) return "starts elsewhere";
  const Integrated x = integrate(profile);
  const double scale = std::max({std::abs(from.p), std::abs(to.p), b.v * b.v / b.a});
  if (!(std::abs(x.p - to.p) <= 1e-9 * scale)) return "misses p by " + std::to_string((double)((x.p - to.p) / scale));
  if (!(std::abs(x.v - to.v) <= 1e-9 * b.v)) return "misses v by " + std::to_string((double)((x.v - to.v) / b.v));
  if (!(std::abs(x.a - to.a) <= 1e-9 * b.a)) return "misses a by " + std::to_string((double)((x.a - to.a) / b.a));
  if (!(x.v_top <= b.v * (1 + 1e-9))) return "speed " + std::to_string((double)(x.v_top / b.v)) + " of its bound";
  if (!(x.a_top <= b.a * (1 + 1e-9)))
    return "acceleration " + std::to_string((double)(x.a_top / b.a)) + " of its bound";
  if (!(x.j_top <= b.j * (1 + 1e-9))) return "jerk " + std::to_string((double)(x.j_top / b.j)) + " of its bound";
  return "";
}

/// A speed bound also needs room for what the acceleration will do, or has done.
inline bool tenable(const State& x, const Bounds& b, double time_sign) {
  const double other = x.v + time_sign * x.a * std::abs(x.a) / (2 * b.j);
  return std::abs(x.v) <= b.v && std::abs(other) <= b.v && std::abs(x.a) <= b.a;
}

/// Shortest duration found by trying motions of the shape s(+ 0 - 0 - 0 +), s = +1 and -1, with the first switching
/// time on a grid, the second solved for the end speed on a grid, and each bracket of the end position bisected. Knows
/// no closed form but the speed after two ramps.
class Search {
 public:
  Search(const State& from, const State& to, const Bounds& b, int grid) : from_(from), to_(to), b_(b), grid_(grid) {}

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

  /// Jerk s for x, with the acceleration held once it has reached the bound.
  void ramp(Moving& m, long double s, long double x) const {
    const long double free = std::max(((long double)b_.a - s * m.a) / b_.j, 0.0L);
    m.go(s * b_.j, std::min(x, free));
    if (x > free) m.go(0, x - free);
  }
  void close(Moving& m, long double s) const { m.go(s * b_.j, std::max((to_.a - m.a) / (s * b_.j), 0.0L)); }

  /// First ramp x; then all second ramps that bring the end speed right.
  std::vector<Trial> trials(long double s, long double x) const {
    std::vector<Trial> out;
    Moving first{from_.p, from_.v, from_.a, 0};
    ramp(first, s, x);
    const auto miss = [&](long double y) {
      Moving m = first;
      ramp(m, -s, y);
      if (s * (to_.a - m.a) < -1e-12L * b_.a) return std::numeric_limits<long double>::quiet_NaN();
      close(m, s);
      return m.v - to_.v;
    };
    const long double begin = std::max(s * (first.a - to_.a) / b_.j, 0.0L);
    const long double span = 2.0L * b_.a / b_.j + 2.0L * b_.v / b_.a + 1e-9L;
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
        const long double crossing = s * first.a > 0 ? s * first.a / b_.j : 0;
        Moving top = first;
        top.go(-s * b_.j, std::min(crossing, lo));
        ramp(m, -s, lo);
        close(m, s);
        out.push_back({m.p, m.t, std::abs(top.v) <= b_.v * (1 + 1e-12L)});
      }
      y0 = y1, f0 = f1;
    }
    return out;
  }

  void take(const Trial& t) {
    if (t.valid && std::abs(t.p - to_.p) <= 1e-10L * std::max({std::abs(from_.p), std::abs(to_.p), b_.v * b_.v / b_.a}))
      best_ = std::min(best_, t.duration);
  }

  void family(long double s) {
    const long double span = (b_.a - s * from_.a) / b_.j + 2.0L * b_.v / b_.a;
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

  /// With an arc on the speed bound: both ends are speed changes, the rest of the way is driven at the bound.
  void coast(long double s) {
    Moving m{from_.p, from_.v, from_.a, 0};
    if (!to_bound(m, s)) return;
    Moving back{0, to_.v, -to_.a, 0};  // reversed time: same speeds, opposite acceleration
    if (!to_bound(back, s)) return;
    const long double rest = to_.p - m.p - back.p;
    if (s * rest >= 0) best_ = std::min(best_, m.t + back.t + s * rest / b_.v);
  }
  bool to_bound(Moving& m, long double s) const {
    long double lo = 0, hi = (b_.a - s * m.a) / b_.j + 3.0L * b_.v / b_.a;
    const auto after = [&](long double x) {
      Moving n = m;
      ramp(n, s, x);
      n.go(-s * b_.j, std::max(s * n.a / b_.j, 0.0L));
      return n;
    };
    if (s * m.a < 0) lo = -s * m.a / b_.j;
    if (s * after(lo).v > b_.v) return false;
    for (int k = 0; k < 80; ++k) {
      const long double mid = (lo + hi) / 2;
      (s * after(mid).v > b_.v ? hi : lo) = mid;
    }
    m = after(lo);
    return true;
  }

  State from_, to_;
  Bounds b_;
  int grid_;
  long double best_ = std::numeric_limits<long double>::infinity();
};

}  // namespace gantry::motion::judge
