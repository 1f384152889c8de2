// The end of a motion, judged by what its start and its target are, not by how far it goes in between.
#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/profile/scale.hpp"

namespace gantry::motion {
namespace {

constexpr double kEnd = 1e-9;       // of the scales of the problem
constexpr double kLongest = 1e-9;   // of the duration, that the end may be moved in time
constexpr double kCoasting = 1e-9;  // of the acceleration: what is left of it while coasting

/// With more digits than the phases have: the path may be 1e10 times as long as its ends are apart.
struct Instant {
  long double p, v, a;
  void go(const Phase& phase) noexcept {
    const long double t = phase.duration_s, j = phase.jerk;
    p += t * (v + t * (a / 2 + t * j / 6));
    v += t * (a + t * j / 2);
    a += t * j;
  }
};

Instant end_of(const Profile& profile) noexcept {
  Instant x{profile.from.p, profile.from.v, profile.from.a};
  for (const Phase& phase : profile.phases) x.go(phase);
  return x;
}

/// No rounding within the motion can matter: not of the speed for as long as it takes, nor of what is left of an
/// acceleration that has ended.
bool surely_exact(const Profile& profile, const AxisBounds& b, double p, double v, double a) noexcept {
  const double seconds = duration(profile), unsure = (v + a * seconds) * std::numeric_limits<double>::epsilon();
  return seconds * unsure <= kEnd / 10 * p && unsure <= kEnd / 10 * std::min(b.v_max, -b.v_min);
}

/// Within the bounds on speed, from a start that is.
bool keeps_speed(const Profile& profile, const AxisBounds& b) noexcept {
  const long double most = b.v_max * (1 + kEnd), least = b.v_min * (1 + kEnd);
  Instant x{profile.from.p, profile.from.v, profile.from.a};
  for (const Phase& phase : profile.phases) {
    const long double turn = phase.jerk != 0 ? -x.a / phase.jerk : -1;
    if (turn > 0 && turn < phase.duration_s && (x.v + x.a * turn / 2 > most || x.v + x.a * turn / 2 < least))
      return false;
    x.go(phase);
    if (x.v > most || x.v < least) return false;
  }
  return true;
}

/// What whoever adds the phases up in doubles may be wrong by at the end: rounding of the highest speed, for as long as
/// the motion takes. (No position is farther away than that speed leads in that time.)
double uncertainty(const Profile& profile) noexcept {
  Instant x{profile.from.p, profile.from.v, profile.from.a};
  long double fastest = std::abs(x.v), seconds = 0;
  for (const Phase& phase : profile.phases) {
    x.go(phase);
    seconds += phase.duration_s;
    fastest = std::max(fastest, std::abs(x.v));
  }
  return static_cast<double>(fastest * seconds) * std::numeric_limits<double>::epsilon() / 2;
}

/// The longest phase at constant speed, and that speed.
Phase* coasting(Profile& profile, double a_bound, long double& v) noexcept {
  Instant x{profile.from.p, profile.from.v, profile.from.a};
  Phase* longest = nullptr;
  for (Phase& phase : profile.phases) {
    const bool coasts = phase.jerk == 0 && std::abs(static_cast<double>(x.a)) <= kCoasting * a_bound && x.v != 0;
    if (coasts && (longest == nullptr || phase.duration_s > longest->duration_s)) longest = &phase, v = x.v;
    x.go(phase);
  }
  return longest;
}

/// Takes the miss out of the coasting phase. False: the phases' durations have no digits for the target.
bool settle(Profile& profile, const State& to, double p, double v, double a) noexcept {
  if (uncertainty(profile) > kEnd * p) return false;
  const auto miss = [&] { return static_cast<double>(end_of(profile).p - to.p); };
  long double speed = 0;
  if (Phase* phase = coasting(profile, a, speed); phase != nullptr && std::abs(miss()) > kEnd / 100 * p) {
    const double wanted = phase->duration_s - static_cast<double>(miss() / speed);
    if (wanted > 0 && std::abs(wanted - phase->duration_s) <= kLongest * duration(profile)) phase->duration_s = wanted;
  }
  const Instant end = end_of(profile);
  return std::abs(miss()) <= kEnd * p && std::abs(static_cast<double>(end.v - to.v)) <= kEnd * v &&
         std::abs(static_cast<double>(end.a - to.a)) <= kEnd * a;
}

}  // namespace

bool arrives(Profile& profile, const State& to, const AxisBounds& b, double scale_p, bool outside) noexcept {
  const double v = std::max(b.v_max, -b.v_min), a = std::max(b.a_max, -b.a_min);
  const double p = std::max({std::abs(profile.from.p), std::abs(to.p), v * v / a});
  double near = std::min(scale_p, p);
  if (const bool sure = surely_exact(profile, b, p, v, a); outside || !sure) {
    if (!settle(profile, to, p, v, a) || !(outside || keeps_speed(profile, b))) return false;
    near = scale_p;  // settle() has judged it by p, with more digits than are here
  }
  const State end = end_state(profile);
  return std::abs(end.p - to.p) <= kEnd * near && std::abs(end.v - to.v) <= kEnd * v &&
         std::abs(end.a - to.a) <= kEnd * a;
}

}  // namespace gantry::motion
