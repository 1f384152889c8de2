// What a route consists of: the states that it goes through, legs between them, its phases.
#include "motion/profile/corridor.hpp"

#include <algorithm>

#include "motion/profile/brake.hpp"

namespace gantry::motion {
namespace {
constexpr double kNear = 10;       // resolutions by which a mix may miss
constexpr double kReached = 5000;  // between the end of a leg and where it leads: half of what the planner grants
}  // namespace

Corridor::Corridor(const State& from, const State& to, const AxisBounds& bounds, double resolution,
                   std::size_t used) noexcept
    : from_(from), to_(to), b_(bounds), resolution_(resolution), used_(used), scale_(bounds) {
  // Where a side is open a rest is looked for no farther than the ends and where they can stop.
  const double ends[] = {
      from.p, to.p, brake_up(from, b_).top, -brake_down(from, b_).top, came_up(to, b_).top, -came_down(to, b_).top};
  rest_low_ = exists(false) ? b_.p_min : *std::min_element(std::begin(ends), std::end(ends));
  rest_high_ = exists(true) ? b_.p_max : *std::max_element(std::begin(ends), std::end(ends));
}

Reason Corridor::reason_of_none() const noexcept {
  const bool stays = brake_up(from_, b_).top <= b_.p_max && -brake_down(from_, b_).top >= b_.p_min;
  return stays ? Reason::NoMotionWithin : Reason::StartCannotStay;
}

State Corridor::at(const Via& via) const noexcept {
  switch (via.kind) {
    case Via::Kind::Upper: return {b_.p_max, 0, -via.share * most(true)};
    case Via::Kind::Lower: return {b_.p_min, 0, via.share * most(false)};
    case Via::Kind::Rest: break;
  }
  return {rest_low_ + via.share * (rest_high_ - rest_low_), 0, 0};
}

double Corridor::outside_by(const Profile& profile) const noexcept {
  const Extent e = extent(profile);
  const double by = std::max(b_.p_min - e.low, e.high - b_.p_max);
  return by > 2 * resolution_ ? by : 0;
}

/// A touch may have an acceleration that would lead out of the speed bounds if it had to be taken out: the target, or
/// the start, can be nearer than that. So speeds are looked at here, and the end: an extremal motion that coasts does
/// so at the bound only when it does not come to it faster.
double Corridor::excess(const Profile& profile, const State& target) const noexcept {
  const double grown = 1 + kSlack;
  State x = profile.from;
  for (const Phase& phase : profile.phases) {
    const double turn = -x.a / phase.jerk, top = x.v + turn * x.a / 2;
    const bool turns = turn > 0 && turn < phase.duration_s;
    if (turns && (top > b_.v_max * grown || top < b_.v_min * grown)) return kNever;
    const double t = phase.duration_s;
    x.p += t * (x.v + t * (x.a / 2 + t * phase.jerk / 6));
    x.v += t * (x.a + t * phase.jerk / 2), x.a += t * phase.jerk;
  }
  return std::abs(x.p - target.p) <= kReached * resolution_ ? outside_by(profile) : kNever;
}

double Corridor::leg(const State& a, const State& b, Profile& out) const noexcept {
  scaled::Reachable reachable(scale_.ends(a, b), scale_.box);
  const double p = (b.p - a.p) / scale_.p, unsure = resolution_ / scale_.p;
  constexpr int kMostStretches = 8;
  scaled::Found f = reachable.first(p, unsure);
  for (int i = 0; i < kMostStretches && f.side != scaled::Side::None && std::isfinite(f.duration); ++i) {
    out.from = a;
    out.phases.clear();
    append(out, reachable.shape(f), scale_);
    if (excess(out, b) == 0) return duration(out);
    f = reachable.next(p, unsure, f);
  }
  return kNever;
}

double Corridor::leg(const State& a, const State& b) const noexcept {
  Profile unused;
  return leg(a, b, unused);
}

double Corridor::slow_leg(const State& a, const State& b, double t, Profile& out) const noexcept {
  out.from = a;
  out.phases.clear();
  scaled::Reachable reachable(scale_.ends(a, b), scale_.box);
  const scaled::Mix mix = reachable.mix(t / scale_.t, (b.p - a.p) / scale_.p, kNear * resolution_ / scale_.p);
  if (!mix.possible) return mix.missing * scale_.p;
  append(out, mix, scale_);
  return excess(out, b);
}

double Corridor::time(const Route& route) const noexcept {
  double sum = 0;
  State x = from_;
  for (const Via& via : route.vias) {
    const State next = at(via);
    sum += leg(x, next);
    if (sum == kNever) return sum;
    x = next;
  }
  return sum + leg(x, to_);
}

double Corridor::later_leg(const State& a, const State& b, double t) const noexcept {
  scaled::Reachable reachable(scale_.ends(a, b), scale_.box);
  const double p = (b.p - a.p) / scale_.p, unsure = resolution_ / scale_.p;
  constexpr int kMostStretches = 4;
  Profile unused;
  scaled::Found f = reachable.first(p, unsure, std::max(t, 0.0) / scale_.t);
  for (int i = 0; i < kMostStretches && f.side != scaled::Side::None && std::isfinite(f.duration); ++i) {
    const double duration = f.side == scaled::Side::Between ? t : f.duration * scale_.t;
    if (slow_leg(a, b, duration, unused) == 0) return duration;
    f = reachable.next(p, unsure, f);
  }
  return kNever;
}

Route Corridor::timed(Route route, double least) const noexcept {
  route.leg_s = {};
  route.duration_s = time(route);
  if (route.duration_s >= least) return route;
  const double spare = least - route.duration_s;
  route.duration_s = kNever;
  State x = from_;
  std::size_t slow = 0;
  double slow_s = 0;
  for (std::size_t i = 0; i <= route.vias.size(); ++i) {
    const State next = i < route.vias.size() ? at(route.vias[i]) : to_;
    const double shortest = leg(x, next), longer = later_leg(x, next, shortest + spare);
    const double total = least - spare - shortest + longer;
    if (total < route.duration_s) route.duration_s = total, slow = i, slow_s = longer;
    x = next;
  }
  route.leg_s[slow] = slow_s;
  return route;
}

bool Corridor::write(const Route& route, Profile& profile) const noexcept {
  Profile part;
  State x = from_;
  std::size_t index = 0;
  const auto join = [&profile](const Phase& phase) {
    if (!profile.phases.empty() && profile.phases.back().jerk == phase.jerk) {
      profile.phases.back().duration_s += phase.duration_s;
      return true;
    }
    return profile.phases.push_back(phase);
  };
  const auto add = [&](const State& next) {
    const double t = route.leg_s[index];
    bool fits = t > 0 ? slow_leg(x, next, t, part) == 0 : leg(x, next, part) < kNever;
    for (const Phase& phase : part.phases) fits = fits && join(phase);
    if (static_cast<int>(index) == route.spare_at && route.spare_s > 0) fits = fits && join({route.spare_s, 0});
    ++index, x = next;
    return fits;
  };
  for (const Via& via : route.vias)
    if (!add(at(via))) return false;
  return add(to_);
}

bool Corridor::sound(const Route& route) const noexcept {
  Profile profile{from_, {}};
  return write(route, profile) && profile.phases.size() + used_ <= kMaxPhases && excess(profile, to_) == 0;
}

}  // namespace gantry::motion
