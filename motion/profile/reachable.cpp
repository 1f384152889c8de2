// From its beginning the interval of reachable p widens; p is reached first at the end on its side. So one of the two
// families is followed, along its regions, to the first T at which it comes to p; where durations are blocked, the
// search goes on behind the gap, with the side chosen anew.
#include "motion/profile/reachable.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gantry::motion::scaled {
namespace {

using Region = Extremal::Region;

constexpr double kBlurred = 4000;  // resolutions that rounding at a family's beginning may cost at most
constexpr double kEps = std::numeric_limits<double>::epsilon();

/// A duration and the region it lies in; negative: none.
struct Moment {
  double t = -1;
  int region = 0;
};

/// Root of p(T) = p in [lo, hi], where it rises through p: Halley's method inside the bracket. Its error goes with the
/// third power, in units of p'/p'': a step of less than kLast of them is the last one.
double root(const Extremal& e, const Region& r, double p, double lo, double hi, double p_lo, double p_hi) noexcept {
  double t = lo + (hi - lo) * std::cbrt((p - p_lo) / (p_hi - p_lo));  // durations count in the third power
  constexpr double kLast = 1e-5;
  for (int i = 0; i < 80; ++i) {
    const auto at = e.curve(t, r);
    const double f = at.p - p;
    // A rounding of T is worth so much, and below it f is noise.
    if (std::abs(f) <= 4 * kEps * (std::abs(p) + std::abs(at.dp_dt) * t)) break;
    (f < 0 ? lo : hi) = t;
    const double newton = f / at.dp_dt, bend = newton * at.d2p_dt2 / at.dp_dt;  // the step in units of p'/p''
    double next = t - newton / (1 - bend / 2);
    if (!(next > lo && next < hi)) {
      next = (lo + hi) / 2;
    } else if (std::abs(bend) <= kLast && std::abs(next - t) <= kLast * t) {
      return next;
    }
    if (std::abs(next - t) <= 2 * kEps * t) break;
    t = next;
  }
  return t;
}

/// First T >= from in the stretch of regions [i, end) at which the family comes to p from below.
Moment rise_to(const Extremal& e, int i, int end, double from, double p, double resolution) noexcept {
  double t = std::max(from, e.region(i).t_begin), at = e.reach(t, e.region(i)).p;
  if (at >= p) return {t, i};
  for (; i < end; ++i) {
    const Region& r = e.region(i);
    if (r.form == Region::Form::Coast) return {std::max(t, r.t_begin) + (p - at) / e.reach(r.t_begin, r).dp_dt, i};
    double knots[3];
    int n = r.convex ? 0 : e.turns(r, knots);
    knots[n++] = r.t_end;
    for (int k = 0; k < n; ++k) {
      if (knots[k] <= t) continue;
      const double next = e.reach(knots[k], r).p;
      if (next >= p) return {root(e, r, p, t, knots[k], at, next), i};
      if (p - next <= resolution) return {knots[k], i};
      t = knots[k], at = next;
    }
  }
  if (p - at <= kBlurred * resolution && p - at <= resolution + e.blur(t, e.region(end - 1))) return {t, end - 1};
  return {};
}

/// Where the component that begins at region `first` ends.
int component_end(const Extremal& e, int first) noexcept {
  int i = first + 1;
  while (i < e.regions() && !e.region(i).after_gap) ++i;
  return i;
}

/// Regions [first, end) of a component; the last one, where rounding has closed a gap.
std::pair<int, int> component(const Extremal& e, int part) noexcept {
  int first = 0, end = component_end(e, 0);
  for (; part > 0 && end < e.regions(); --part) {
    first = end;
    end = component_end(e, first);
  }
  return {first, end};
}

int region_at(const Extremal& e, int first, int end, double t) noexcept {
  while (first + 1 < end && e.region(first).t_end < t) ++first;
  return first;
}

}  // namespace

const Extremal& Reachable::down() noexcept {
  if (!down_) down_.emplace(mirrored(ends_), mirrored(box_));
  return *down_;
}

Found Reachable::first(double p, double resolution, double from_t) noexcept {
  for (int part = 0, up = 0; up < up_.regions(); ++part) {
    const int up_end = component_end(up_, up);
    const double begin = up_.region(up).t_begin;
    if (from_t <= std::max(up_.region(up_end - 1).t_end, 0.0)) {
      const double t = std::max(from_t, begin);
      const int i = region_at(up_, up, up_end, t);
      const double most = up_.reach(t, up_.region(i)).p;
      if (std::abs(p - most) <= kBlurred * resolution) {
        // Where a component begins there is one motion alone, known as well as D is.
        const double unsure = resolution + (t > begin ? 0 : up_.blur(t, up_.region(i)));
        if (std::abs(p - most) <= unsure) return {t, Side::Up, i};
      }
      if (p > most) {
        const Moment found = rise_to(up_, i, up_end, t, p, resolution);
        if (found.t >= 0) return {found.t, Side::Up, found.region};
      } else {
        const auto [first, end] = component(down(), part);
        const int k = region_at(down(), first, end, t);
        if (t > begin && -down().reach(t, down().region(k)).p <= p) return {t, Side::Between, i};
        const Moment found = rise_to(down(), k, end, t, -p, resolution);
        if (found.t >= 0) return {found.t, Side::Down, found.region};
      }
    }
    up = up_end;
  }
  return {};
}

// A stretch ends at the end of its component, or where an end of the interval passes p; between its turns and the ends
// of its regions that end moves in one direction, so that looking there is enough.
Found Reachable::next(double p, double resolution, const Found& found) noexcept {
  double from_t = std::numeric_limits<double>::infinity();
  const auto look = [&](const Extremal& e, double sign) {
    for (int i = 0; i < e.regions(); ++i) {
      const Region& r = e.region(i);
      if (r.after_gap && r.t_begin > found.duration) from_t = std::min(from_t, r.t_begin);
      double knots[3];
      int n = r.convex ? 0 : e.turns(r, knots);
      knots[n++] = r.t_end;
      for (int k = 0; k < n; ++k)
        if (knots[k] > found.duration && knots[k] < from_t && e.reach(knots[k], r).p < sign * p - resolution)
          from_t = knots[k];
    }
  };
  look(up_, 1);
  look(down(), -1);
  if (!(from_t < std::numeric_limits<double>::infinity())) return {};
  Found f = first(p, resolution, from_t);
  return f.side == Side::Between ? Found{} : f;
}

Shape Reachable::shape(const Found& found) noexcept {
  if (found.side == Side::Up) return up_.shape(found.duration, up_.region(found.region));
  Shape s = down().shape(found.duration, down().region(found.region));
  for (double& j : s.j) j = -j;
  return s;
}

Mix Reachable::mix(double duration, double p, double resolution) noexcept {
  Mix m;
  const double slack = 64 * kEps * duration;
  const Extremal::Region* const a = up_.find(duration, slack);
  const Extremal::Region* const b = down().find(duration, slack);
  if (a == nullptr || b == nullptr) {
    m.missing = std::numeric_limits<double>::infinity();
    return m;
  }
  const double most = up_.reach(duration, *a).p, least = -down().reach(duration, *b).p, room = most - least;
  m.missing = std::max({p - most, least - p, 0.0});
  m.possible = m.missing <= resolution;
  m.share = room > 0 ? std::clamp((p - least) / room, 0.0, 1.0) : 1;
  if (m.share > 0) m.up = up_.shape(duration, *a);
  if (m.share < 1) {
    m.down = down().shape(duration, *b);
    for (double& j : m.down.j) j = -j;
  }
  return m;
}

}  // namespace gantry::motion::scaled
