// Position limits. Where the shortest motion would leave them, the best one touches: it comes to a limit with speed 0
// and some acceleration that leads back, and goes on from there. Both legs are shortest motions, so that what is left
// is the acceleration at the touch: one number for one touch, two where it goes from one limit to the other.
#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/profile/scale.hpp"

namespace gantry::motion {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr int kGrid = 48;    // tries over the range of accelerations (the way between the limits can be narrow), then
constexpr int kRefine = 30;  // golden sections around the best
constexpr double kGolden = 0.6180339887498949;

class Walls {
 public:
  Walls(const AxisBounds& b, double resolution) noexcept : b_(b), resolution_(resolution) {}

  [[nodiscard]] bool holds(const Profile& p) const noexcept {
    const Extent e = extent(p);
    return e.low >= b_.p_min - 2 * resolution_ && e.high <= b_.p_max + 2 * resolution_;
  }

  /// Duration of the shortest motion when it stays inside; kNever otherwise.
  double leg(const State& from, const State& to, Profile& out) const noexcept {
    out = {from, {}};
    if (append_shortest(from, to, b_, out, resolution_) != Reason::Solved || !holds(out)) return kNever;
    return duration(out);
  }

  /// At the upper limit the acceleration leads down, at the lower one up; as strong as the speed bounds on both sides
  /// of the touch bear.
  [[nodiscard]] State touch(bool upper, double share) const noexcept {
    const double rate = 2 * std::min(upper ? -b_.j_min * b_.v_max : b_.j_max * -b_.v_min,
                                     upper ? b_.j_max * -b_.v_min : -b_.j_min * b_.v_max);
    const double most = std::min(upper ? -b_.a_min : b_.a_max, std::sqrt(rate));
    return {upper ? b_.p_max : b_.p_min, 0, (upper ? -1 : 1) * share * most};
  }
  [[nodiscard]] bool exists(bool upper) const noexcept { return std::isfinite(upper ? b_.p_max : b_.p_min); }

 private:
  AxisBounds b_;
  double resolution_;
};

/// Least value over [0, 1]: a grid, then golden sections beside its best point. Returns where.
template <class Value>
double best_share(Value&& value) noexcept {
  double best = 0, least = value(0.0);
  for (int i = 1; i <= kGrid; ++i) {
    const double x = static_cast<double>(i) / kGrid, y = value(x);
    if (y < least) least = y, best = x;
  }
  if (least == kNever) return best;
  double lo = std::max(best - 1.0 / kGrid, 0.0), hi = std::min(best + 1.0 / kGrid, 1.0);
  double a = hi - kGolden * (hi - lo), b = lo + kGolden * (hi - lo), fa = value(a), fb = value(b);
  for (int i = 0; i < kRefine; ++i) {
    if (fa < fb) {
      hi = b, b = a, fb = fa;
      a = hi - kGolden * (hi - lo), fa = value(a);
    } else {
      lo = a, a = b, fa = fb;
      b = lo + kGolden * (hi - lo), fb = value(b);
    }
  }
  const double x = fa < fb ? a : b;
  return std::min(fa, fb) < least ? x : best;
}

struct Route {
  double t = kNever;
  rt::FixedVector<State, 2> touches;
};

void take(Route& best, const Route& other) noexcept {
  if (other.t < best.t) best = other;
}

Route one_touch(const Walls& walls, const State& from, const State& to, bool upper) noexcept {
  Profile leg;
  const auto time = [&](double share) {
    const State x = walls.touch(upper, share);
    const double first = walls.leg(from, x, leg);
    return first == kNever ? kNever : first + walls.leg(x, to, leg);
  };
  const double share = best_share(time);
  Route route{time(share), {}};
  route.touches.push_back(walls.touch(upper, share));
  return route;
}

/// Over one limit to the other. The legs outside the touches each depend on one of them: both are refined in turn.
Route two_touches(const Walls& walls, const State& from, const State& to, bool upper_first) noexcept {
  Profile leg;
  const auto time = [&](double first, double second) {
    const State a = walls.touch(upper_first, first), b = walls.touch(!upper_first, second);
    const double begin = walls.leg(from, a, leg);
    if (begin == kNever) return kNever;
    const double end = walls.leg(b, to, leg);
    return end == kNever ? kNever : begin + end + walls.leg(a, b, leg);
  };
  double first = 0, second = 0, least = kNever;
  constexpr int kCoarse = 6;
  for (int i = 0; i <= kCoarse; ++i)
    for (int k = 0; k <= kCoarse; ++k) {
      const double x = static_cast<double>(i) / kCoarse, y = static_cast<double>(k) / kCoarse, t = time(x, y);
      if (t < least) least = t, first = x, second = y;
    }
  if (least == kNever) return {};
  for (int round = 0; round < 3; ++round) {
    first = best_share([&](double x) { return time(x, second); });
    second = best_share([&](double y) { return time(first, y); });
  }
  Route route{time(first, second), {}};
  route.touches.push_back(walls.touch(upper_first, first));
  route.touches.push_back(walls.touch(!upper_first, second));
  return route;
}

}  // namespace

Reason append_between_walls(const State& from, const State& to, const AxisBounds& bounds, Profile& profile,
                            double resolution) noexcept {
  const Walls walls(bounds, resolution);
  Profile leg;
  const auto add = [&](const State& a, const State& b) {
    walls.leg(a, b, leg);
    for (const Phase& phase : leg.phases) profile.phases.push_back(phase);
  };
  if (walls.leg(from, to, leg) != kNever) {
    add(from, to);
    return Reason::Solved;
  }
  Route best;
  for (const bool upper : {true, false})
    if (walls.exists(upper)) take(best, one_touch(walls, from, to, upper));
  if (best.t == kNever && walls.exists(true) && walls.exists(false))
    for (const bool upper : {true, false}) take(best, two_touches(walls, from, to, upper));
  if (best.t == kNever) {
    const bool stays = walls.holds(stop(from, bounds).profile);
    return stays ? Reason::NoWayWithin : Reason::StartCannotStay;
  }
  State at = from;
  for (const State& touch : best.touches) add(at, touch), at = touch;
  add(at, to);
  return Reason::Solved;
}

}  // namespace gantry::motion
