// Time to spare between position limits. In this order: as if there were none; that motion, bent; a rest in between; a
// gentler touch; legs that take longer. Where none of these takes exactly t, the shortest that takes longer.
#include <algorithm>

#include "motion/profile/corridor.hpp"

namespace gantry::motion {
namespace {

constexpr int kRests = 16;          // intervals between the limits
constexpr double kSettled = 1e-13;  // relative: durations that are one
constexpr int kStride = 3;          // of the nodes that are tried in pairs
constexpr double kBent = 1e-7;      // of t and of the accelerations: to which a bent motion is sought

}  // namespace

Route Corridor::first(double t) noexcept {
  double bendable = t;
  Route route = unbent(bendable);
  if (route) return route;
  if ((route = bent(bendable)) && bendable <= t) return route;
  const Route gap = route;
  nodes_ = 0;
  add_contacts();
  add_rests();
  std::sort(node_.begin(), node_.begin() + nodes_, [](const Node& a, const Node& b) {
    return a.via.kind != b.via.kind ? a.via.kind < b.via.kind : a.via.share < b.via.share;
  });
  for (const bool far : {false, true}) {
    if (far) explore(kNever);
    for (const auto waiting : {&Corridor::resting, &Corridor::gentler, &Corridor::slower})
      if ((route = (this->*waiting)(t)) && route.duration_s <= t * (1 + kSettled)) return route;
  }
  route = later(t);
  return gap.duration_s < route.duration_s ? gap : route;
}

void Corridor::add_rests() noexcept {
  for (int i = 0; i <= kRests; ++i) add({Via::Kind::Rest, static_cast<double>(i) / kRests});
}

/// The first duration >= t that is not blocked without limits (t becomes it), where its motion happens to keep them.
Route Corridor::unbent(double& t) const noexcept {
  scaled::Reachable reachable(scale_.ends(from_, to_), scale_.box);
  const scaled::Found f = reachable.first((to_.p - from_.p) / scale_.p, resolution_ / scale_.p, t / scale_.t);
  Route route;
  if (f.side == scaled::Side::None || !std::isfinite(f.duration)) return route;
  if (f.side != scaled::Side::Between) t = f.duration * scale_.t;
  route.leg_s[0] = t;
  if (sound(route)) route.duration_s = t;
  return route;
}

/// That motion, bent: where it is farthest outside it touches instead, at a time and with an acceleration that are
/// sought from there (compass search for the least excess).
Route Corridor::bent(double t) const noexcept {
  Profile free;
  (void)slow_leg(from_, to_, t, free);
  double at_s = -1, farthest = 0, begin = 0;
  Route route;
  State x = from_;
  for (const Phase& phase : free.phases) {
    const double disc = x.a * x.a - 2 * phase.jerk * x.v;
    const double q = -(x.a + std::copysign(std::sqrt(std::max(disc, 0.0)), x.a));
    for (const double u : {q / phase.jerk, q != 0 ? 2 * x.v / q : 0}) {
      if (!(disc >= 0 && u > 0 && u < phase.duration_s)) continue;
      const double p = x.p + u * (x.v + u * (x.a / 2 + u * phase.jerk / 6)), a = x.a + u * phase.jerk;
      const double by = std::max(p - b_.p_max, b_.p_min - p);
      if (by <= farthest) continue;
      const bool upper = p > b_.p_max;
      farthest = by, at_s = begin + u, route.vias.clear();
      route.vias.push_back({upper ? Via::Kind::Upper : Via::Kind::Lower, std::min(std::abs(a) / most(upper), 1.0)});
    }
    begin += phase.duration_s;
    Profile step{x, {}};
    step.phases.push_back(phase);
    x = end_state(step);
  }
  if (at_s < 0) return {};
  const auto set = [t](Route r, double time_s, double share) {
    r.leg_s[0] = time_s, r.leg_s[1] = t - time_s, r.vias[0].share = share;
    return r;
  };
  route = set(route, at_s, route.vias[0].share);
  double least = miss(route);
  constexpr int kMostTries = 400;
  int tries = 0;
  for (double step = 0.1; step > kBent && least > 0 && tries < kMostTries; step /= 2)
    for (bool better = true; better && least > 0 && tries < kMostTries;) {
      better = false;
      for (const auto& [dt, da] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}) {
        const double share = route.vias[0].share + da * step, time_s = route.leg_s[0] + dt * step * t;
        if (share < 0 || share > 1 || time_s <= 0 || time_s >= t) continue;
        const Route other = set(route, time_s, share);
        const double by = miss(other);
        ++tries;
        if (by < least) route = other, least = by, better = true;
      }
    }
  if (least == 0 && sound(route)) route.duration_s = t;
  return route;
}

/// By how much its two slow legs miss.
double Corridor::miss(const Route& route) const noexcept {
  Profile unused;
  const State x = at(route.vias[0]);
  return slow_leg(from_, x, route.leg_s[0], unused) + slow_leg(x, to_, route.leg_s[1], unused);
}

Route Corridor::resting(double t) noexcept {
  Route best;
  for (int i = 0; i < nodes_; ++i) {
    if (!node(i).via.rests() || node(i).since + node(i).until > t) continue;
    Route route = route_to(i);
    route.spare_at = static_cast<std::int8_t>(route.vias.size() - 1);
    route.spare_s = t - route.duration_s;
    route.duration_s = t;
    if (route.spare_s >= 0 && sound(route)) return route;
  }
  return best;
}

/// Between two neighbours of which one takes less than t and one longer.
Route Corridor::gentler(double t) noexcept {
  for (int i = 1; i < nodes_; ++i) {
    const Node &a = node(i - 1), &b = node(i);
    if (a.via.kind != b.via.kind || a.before != b.before) continue;
    Route low = route_to(i - 1), high = route_to(i);
    if (low.duration_s > high.duration_s) std::swap(low, high);
    if (!(low.duration_s <= t && high.duration_s >= t && high)) continue;
    for (int n = 0; n < 60 && high.duration_s - low.duration_s > kSettled * t; ++n) {
      Route middle = low;
      middle.vias.back().share = (low.vias.back().share + high.vias.back().share) / 2;
      middle.duration_s = time(middle);
      (middle.duration_s > t ? high : low) = middle;
    }
    for (const Route& route : {high, low})
      if (std::abs(route.duration_s - t) <= kSettled * t && sound(route)) return route;
  }
  return {};
}

/// What there is to spare goes to the last leg, to the one before it, or to both.
Route Corridor::slower(double t) noexcept {
  for (const double share : {1.0, 0.0, 0.5, 0.25, 0.75, 0.1, 0.9})
    for (int i = 0; i < nodes_; ++i) {
      const Node& n = node(i);
      if (!(n.since + n.until <= t) || (n.before >= 0 && share < 1)) continue;
      Route route = route_to(i);
      const double spare = t - route.duration_s;
      route.duration_s = t;
      if (share < 1) route.leg_s[0] = n.since + (1 - share) * spare;
      if (share > 0) route.leg_s[route.vias.size()] = n.until + share * spare;
      if (sound(route)) return route;
    }
  return {};
}

/// The shortest that takes t or longer: through one state (of each kind the best is refined), or two on opposite sides.
Route Corridor::later(double t) noexcept {
  std::array<Route, 5> best;
  const auto take = [&](Route route, std::size_t kind) {
    route = timed(route, t);
    if (route.duration_s < best[kind].duration_s && sound(route)) best[kind] = route;
  };
  for (int i = 0; i < nodes_; ++i)
    if (node(i).since + node(i).until < kNever) take(route_to(i), static_cast<std::size_t>(node(i).via.kind));
  for (int i = 0; i < nodes_; i += kStride)
    for (int k = 0; k < nodes_; k += kStride) {
      const Node &a = node(i), &b = node(k);
      const bool opposite = a.via.kind != b.via.kind && a.via.kind != Via::Kind::Rest && b.via.kind != Via::Kind::Rest;
      if (!opposite || a.before >= 0 || a.since + b.until == kNever) continue;
      Route route;
      route.vias.push_back(a.via), route.vias.push_back(b.via);
      take(route, a.via.kind == Via::Kind::Upper ? 3 : 4);
    }
  for (Route& route : best) {
    if (!route) continue;
    refine(route, t);
    if (sound(route) && route.duration_s < best[0].duration_s) best[0] = route;
  }
  return best[0];
}

}  // namespace gantry::motion
