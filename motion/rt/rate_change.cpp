#include "motion/rt/rate_change.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "motion/geometry.hpp"
#include "motion/rt/differences.hpp"

namespace gantry::motion {
namespace {

// Where the path is slow the limits would let the rate change within a tick; it takes at least so many.
constexpr double kLeastTicks = 8;
constexpr double kWithin = 1.01;                        // of the jerk limit where a tick ends
constexpr double kSwing = 0.02;                         // how far a change may leave the range of its two rates
constexpr double kThere = 1e-12;                        // a rate that is there but for rounding
constexpr double kWithinTick = 1 - 1e-6;                // what is come to in a tick is not come to before it
constexpr std::array<double, 3> kLower{0.6, 0.8, 0.9};  // of the rate, where there is no way to stop from it

/// Derivatives of the planned motion by planned time.
struct Planned {
  AxisVec q{}, n1{}, n2{}, n3{};
};

Planned planned(const PieceCursor& at, std::size_t axes) noexcept {
  const Along x = along(at.piece().nominal, at.t());
  const double v = x.x.v, a = x.x.a;
  const GeometryJet g = jet(at.piece().geometry, x.x.p);
  Planned out;
  out.q = g.q;
  for (std::size_t i = 0; i < axes; ++i) {
    out.n1[i] = g.d1[i] * v;
    out.n2[i] = g.d2[i] * v * v + g.d1[i] * a;
    out.n3[i] = g.d3[i] * v * v * v + 3 * g.d2[i] * v * a + g.d1[i] * x.jerk;
  }
  return out;
}

/// What r'' may be over the next tick, by what the limits leave here; `n3_end`: n3 where the tick ends.
std::pair<double, double> room(const Planned& x, const AxisVec& n3_end, const Rate& now, const Limits& limits,
                               double use) noexcept {
  const double h = limits.tick_s, cap = 4 / (kLeastTicks * kLeastTicks * h * h);
  double low = -cap, high = cap;
  const auto within = [&](double slope, double constant, double limit) {  // |constant + slope r''| <= limit
    const double reach = limit / std::abs(slope), middle = -constant / slope;
    low = std::max(low, middle - reach), high = std::min(high, middle + reach);
  };
  const double r = now.r, next = r + now.slope * h;
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const double later1 = x.n1[i] + h * r * x.n2[i], later2 = x.n2[i] + h * r * x.n3[i];  // at the end of the tick
    const auto jerk = [&](double n1, double n2, double n3, double rate, double after) {
      const double slope = n1 + 3 * n2 * rate * after;
      if (std::abs(slope) > 1e-9)
        within(slope, n3 * rate * rate * rate + 3 * n2 * rate * now.slope, limits.axis[i].j_max);
    };
    jerk(x.n1[i], x.n2[i], x.n3[i], r, 0);
    jerk(later1, later2, n3_end[i], next, h);
    if (std::abs(later1) > 1e-9) within(later1 * h, later2 * next * next + later1 * now.slope, limits.axis[i].a_max);
  }
  return {low < 0 ? use * low : low, high > 0 ? use * high : high};
}

/// The lowest and the highest rate on the way to `to`. To another rate than 0 there is no swinging: it leaves the range
/// of the two rates by kSwing at most, and by what a rate that changes already goes on: no farther than `leads_to`, the
/// end of the change under way.
std::pair<double, double> rates_on_the_way(const Planned& x, const Rate& from, double to, double leads_to,
                                           const Limits& limits, const RateChange::Vigour& vigour) noexcept {
  if (!(to > 0)) return {0, std::max(1.0, from.r) + 1e-9};
  double reached = from.r;
  if (from.slope * (leads_to - from.r) > 0) {
    const auto [low, high] = room(x, x.n3, from, limits, vigour.use);
    const double against = from.slope > 0 ? -low : high;
    const double least = against > 0 ? from.slope * from.slope / (2 * vigour.land * against) : 1;
    reached += std::copysign(std::min(std::abs(leads_to - from.r), least), from.slope);
  }
  const auto [low, high] = std::minmax({from.r, to, reached});
  return {std::max(0.0, low - kSwing), std::min(std::max({1.0, from.r, to}) + 1e-9, high + kSwing)};
}

/// A tick of a change: its r'' and where that leads.
struct Bent {
  RateChange::Step step;
  double bend = 0;
  bool landed = false;  ///< at the rate that is wanted, and to stay there
};

Bent toward(double to, const Rate& now, double low, double high, double land, double h) noexcept {
  const double gap = to - now.r;
  const bool up = gap != 0 ? gap > 0 : now.slope < 0;
  const double against = up ? low : high;
  double bend = up ? high : low;
  if (std::abs(gap) <= kThere && std::abs(now.slope) * h <= kThere) return {{to * h, {to, 0}}, 0, true};
  if (now.slope * gap > 0) {
    // With r'' = -r'^2/(2 gap) the slope ends where the gap does; begun when that takes the room there is.
    const double landing = -now.slope * now.slope / (2 * gap);
    const double next_gap = gap - h * (now.slope + bend * h / 2), next_slope = now.slope + bend * h;
    const bool late = next_gap * gap <= 0 || next_slope * next_slope > 2 * std::abs(next_gap * against) * land;
    if (late) bend = std::clamp(landing, low, high);
    const double rest = 2 * gap / now.slope;
    if (late && bend == landing && rest <= h)  // r = to - gap (1 - t/rest)^2 until rest
      return {{to * h - gap * rest / 3, {to, 0}}, bend, true};
  } else {  // as it sets out: no more than it can land from a tick later
    const double sign = up ? 1 : -1, a = std::abs(against) * land, slope = sign * now.slope;
    const double most = (std::sqrt(a * h * (a * h - 4 * slope) + 8 * a * std::abs(gap)) - 2 * slope - a * h) / (2 * h);
    bend = std::clamp(sign * most, low, high);
  }
  return {{h * (now.r + h * (now.slope / 2 + h * bend / 6)),
           {now.r + h * (now.slope + h * bend / 2), now.slope + h * bend}},
          bend,
          false};
}

/// Where a tick ends, with the planned jerk that is there.
bool keeps_jerk(const Planned& x, const Bent& bent, const Limits& limits) noexcept {
  const auto [r, slope] = bent.step.end;
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const double jerk = x.n3[i] * r * r * r + 3 * x.n2[i] * r * slope + x.n1[i] * bent.bend;
    if (std::abs(jerk) > kWithin * limits.axis[i].j_max) return false;
  }
  return true;
}

}  // namespace

bool RateChange::plan(PieceCursor at, const Rate& from, double to, const Recent& recent, const Limits& limits,
                      const Vigour& vigour, double shorter_s) noexcept {
  too_long_ = false;
  double ahead_s = 0;
  const double h = limits.tick_s;
  auto& steps = steps_[1 - active_];
  Differences judge(recent, limits);
  Planned x = planned(at, limits.axes);
  const double leads_to = under_way() ? steps_[active_][size_ - 1].end.r : from.r;
  const auto [lowest, highest] = rates_on_the_way(x, from, to, leads_to, limits, vigour);
  Rate now = from;
  for (std::size_t n = 0; n < kMostTicks; ++n) {
    PieceCursor end = at;
    PieceCursor::Met met{};
    Bent bent;
    Planned there = x;
    // As if the planned jerk stayed as it is; where it does not, once more with the one at the tick's end.
    for (const bool again : {false, true}) {
      const auto [low, high] = room(x, there.n3, now, limits, vigour.use);
      if (low > high) return false;
      ++work_;
      bent = toward(to, now, low, high, vigour.land, h);
      const RateChange::Step& step = bent.step;
      if (step.end.r < lowest || step.end.r > highest || step.ahead < 0) return false;
      end = at;
      met = end.advance(step.ahead);
      if (met == PieceCursor::Met::Unknown) break;
      there = planned(end, limits.axes);
      if (again || bent.landed || keeps_jerk(there, bent, limits)) break;
    }
    ahead_s += bent.step.ahead;
    if (ahead_s >= shorter_s) return false;
    if (met == PieceCursor::Met::Unknown) break;
    steps[n] = bent.step;
    at = end, x = there, now = bent.step.end;
    if (!judge.keeps_limits(x.q)) return false;
    if (!bent.landed && met != PieceCursor::Met::Rest) continue;
    for (int k = 0; k < 3; ++k) {
      if (met == PieceCursor::Met::Piece && at.advance(to * h) == PieceCursor::Met::Unknown) return false;
      if (!judge.keeps_limits(planned(at, limits.axes).q)) return false;
    }
    active_ = 1 - active_;
    next_ = 0;
    size_ = n + 1;
    stop_ = kStops.size();
    return true;
  }
  too_long_ = true;
  return false;
}

std::optional<double> RateChange::stop(const PieceCursor& from, const Rate& now, const Recent& recent,
                                       const Limits& limits, unsigned& tries) noexcept {
  const std::size_t harder = stop_;
  const double all_s = static_cast<double>(kMostTicks) * limits.tick_s;
  const double left_s =
      harder < kStops.size() ? ahead(all_s, 0, limits.tick_s) : std::numeric_limits<double>::infinity();
  work_ = 0;
  if (tries == 0) lowered_ = 0, lower_next_ = false;
  if (std::exchange(lower_next_, false)) {
    const std::size_t n = lowered_++;
    const double lower = kLower[n % kLower.size()] * now.r;
    const Vigour& vigour = kStops[n / kLower.size() % kStops.size()];
    return plan(from, now, lower, recent, limits, vigour) ? std::optional(lower) : std::nullopt;
  }
  bool too_long = false;
  for (std::size_t n = 0; n < harder && work_ < kEnoughWork; ++n) {
    const std::size_t which = tries++ % harder;
    if (!plan(from, now, 0, recent, limits, kStops[which], left_s)) {
      too_long |= too_long_;
      continue;
    }
    stop_ = which;
    return 0;
  }
  // Where the limits forbid it the next cycle may allow it: a weak way to a lower rate would only be in its way.
  const bool falls = under_way() && steps_[active_][size_ - 1].end.r < now.r;
  lower_next_ = too_long && !falls && harder == kStops.size();
  return std::nullopt;
}

double RateChange::ahead(double seconds, double after, double tick_s) const noexcept {
  double sum = 0;
  for (std::size_t n = next_; n < size_ && seconds > 0; ++n) {
    const double share = std::min(1.0, seconds / tick_s);
    sum += share * steps_[active_][n].ahead;
    seconds -= share * tick_s;
  }
  return sum + std::max(seconds, 0.0) * after;
}

double RateChange::until(double planned_s, double after, double tick_s) const noexcept {
  double seconds = 0;
  for (std::size_t n = next_; n < size_; ++n) {
    const Step& step = steps_[active_][n];
    seconds += tick_s;
    const double over = step.ahead - planned_s;
    if (over >= 0) return seconds - (step.end.r > 0 ? std::min(over / step.end.r, kWithinTick * tick_s) : 0);
    planned_s = -over;
  }
  return seconds + planned_s / after;
}

}  // namespace gantry::motion
