#include "motion/rt/approach.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr int kHalvings = 52;

/// Halves between a value that fits and one that does not; the last that fits.
template <class Fits>
double nearest(double fits, double wanted, const Fits& is_fit) noexcept {
  for (int i = 0; i < kHalvings; ++i) {
    const double mid = (fits + wanted) / 2;
    (is_fit(mid) ? fits : wanted) = mid;
  }
  return fits;
}

double coming_speed(const State& x, double j) noexcept {  // with the acceleration taken out
  return std::max(x.v + x.a * std::abs(x.a) / (2 * j), 0.0);
}

/// True when the speed never falls below 0 (beyond rounding).
bool forward(const Profile& profile) noexcept {
  State x = profile.from;
  const double allowed = -1e-12 * (1 + x.v);
  for (const Phase& phase : profile.phases) {
    const double turn = phase.jerk > 0 ? -x.a / phase.jerk : 0;  // lowest speed inside a phase of rising acceleration
    if (turn > 0 && turn < phase.duration_s && x.v + x.a * turn / 2 < allowed) return false;
    x.v += phase.duration_s * (x.a + phase.duration_s * phase.jerk / 2);
    x.a += phase.duration_s * phase.jerk;
    if (x.v < allowed) return false;
  }
  return true;
}

/// A change to a coasting speed, coasting, and braking to rest: used where the shortest motion would go back, or where
/// a lowered speed bound has to be eased to.
Profile over_coasting(const State& x, double room, const Bounds& bounds) noexcept {
  const auto total = [&](double v) {
    return distance_to_speed(x, v, bounds) + change_length(v, 0, bounds.a, bounds.j);
  };
  const double coming = std::min(coming_speed(x, bounds.j), bounds.v);
  const double fits = total(coming) <= room ? coming : 0;
  const double v =
      total(bounds.v) <= room ? bounds.v : nearest(fits, bounds.v, [&](double w) { return total(w) <= room; });
  Profile out = change_speed(x, v, bounds).profile;
  const double rest = room - total(v);
  if (rest > 0 && v > 0) out.phases.push_back({rest / v, 0});
  for (const Phase& phase : change_speed({0, v, 0}, 0, bounds).profile.phases) out.phases.push_back(phase);
  return out;
}

}  // namespace

double distance_to_speed(const State& x, double v_to, const Bounds& bounds) noexcept {
  return end_state(change_speed(x, v_to, bounds).profile).p - x.p;
}

Approach approach(const State& x, double length, const Bounds& bounds) noexcept {
  Approach out;
  const double room = length - x.p;
  if (distance_to_speed(x, 0, bounds) > room + kLengthSlack) return out;
  out.found = true;
  if (std::max(x.v, coming_speed(x, bounds.j)) <= bounds.v) {
    const Plan shortest = move(x, {length, 0, 0}, bounds);
    const double miss = shortest ? std::abs(end_state(shortest.profile).p - length) : 0;
    if (shortest && miss <= 10 * kLengthSlack && forward(shortest.profile)) {
      out.profile = shortest.profile;
      return out;
    }
  }
  out.profile = over_coasting(x, room, bounds);
  return out;
}

}  // namespace gantry::motion
