// The velocity interface of several axes. For a fixed duration T the speeds that can be met are an interval too: its
// ends are the motions that rise (jerk +j_up, 0, -j_down) and that fall first, and a mix of the two meets any speed
// between.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "motion/profile/arrive.hpp"
#include "motion/profile/scale.hpp"

namespace gantry::motion {
namespace {

/// One end of the interval: the motion that rises first, or its mirror (sign -1).
struct SpeedExtremal {
  double sign, v0, a0, vf, af, a_max, j_up, j_down;

  SpeedExtremal(double s, const State& from, const State& to, const AxisBounds& b) noexcept
      : sign(s),
        v0(s * from.v),
        a0(s * from.a),
        vf(s * to.v),
        af(s * to.a),
        a_max(s > 0 ? b.a_max : -b.a_min),
        j_up(s > 0 ? b.j_max : -b.j_min),
        j_down(s > 0 ? -b.j_min : b.j_max) {}

  struct Arc {
    double rise = 0, hold = 0, fall = 0;
  };
  /// The phases that take T; T >= what one ramp needs.
  [[nodiscard]] Arc arc(double t) const noexcept {
    const double peak = (t + a0 / j_up + af / j_down) / (1 / j_up + 1 / j_down);
    if (peak <= a_max) return {(peak - a0) / j_up, 0, (peak - af) / j_down};
    const double rise = (a_max - a0) / j_up, fall = (a_max - af) / j_down;
    return {rise, t - rise - fall, fall};
  }
  [[nodiscard]] double gain(const Arc& m) const noexcept {
    const double peak = a0 + m.rise * j_up;
    return (a0 + peak) / 2 * m.rise + peak * m.hold + (peak + af) / 2 * m.fall;
  }
  /// The later of the durations in which it meets the speed; negative: never.
  [[nodiscard]] double crossing() const noexcept {
    const double c = (1 / j_up + 1 / j_down) / 2, g = vf - v0 + a0 * a0 / (2 * j_up) + af * af / (2 * j_down);
    if (g < 0) return -1;
    const double peak = std::min(std::sqrt(g / c), a_max);
    if (peak < std::max(a0, af)) return -1;
    return (peak - a0) / j_up + (g - c * peak * peak) / a_max + (peak - af) / j_down;
  }
};

class SpeedTrajectory {
 public:
  SpeedTrajectory(const AxisMove& m) noexcept
      : plan_(change_speed(m.from, m.to.v, m.bounds, m.to.a)), bounds_(m.bounds), to_(m.to) {
    if (!plan_) return;
    entered_.from = m.from;
    const bool outside = m.from.a > m.bounds.a_max || m.from.a < m.bounds.a_min;
    if (outside) entered_.phases.push_back(plan_.profile.phases[0]);
    inside_ = end_state(entered_);
    entered_s_ = gantry::motion::duration(entered_);
    shortest_s_ = gantry::motion::duration(plan_.profile);
  }

  [[nodiscard]] Reason reason() const noexcept { return plan_.reason; }
  [[nodiscard]] double shortest_s() const noexcept { return shortest_s_; }

  double first_s(double t) const noexcept {
    if (t <= shortest_s_ * (1 + kEqual)) return shortest_s_;
    if (share(t - entered_s_)) return t;
    double next = -1;
    for (const double sign : {1.0, -1.0}) {
      const double at = entered_s_ + SpeedExtremal(sign, inside_, to_, bounds_).crossing();
      if (at > t && (next < 0 || at < next)) next = at;
    }
    return next;
  }

  [[nodiscard]] Reason reason_of_none() const noexcept { return Reason::NoSolution; }

  bool write(double t, Profile& profile) const noexcept {
    if (std::abs(t - shortest_s_) <= kEqual * t) {
      profile = plan_.profile;
      return true;
    }
    const auto part = share(t - entered_s_);
    if (!part) return false;
    profile = entered_;
    const SpeedExtremal rise(1, inside_, to_, bounds_), fall(-1, inside_, to_, bounds_);
    const auto up = rise.arc(t - entered_s_), down = fall.arc(t - entered_s_);
    // Cut where either changes its jerk.
    std::array<double, 6> cuts{up.rise,   up.rise + up.hold,     up.rise + up.hold + up.fall,
                               down.rise, down.rise + down.hold, down.rise + down.hold + down.fall};
    std::sort(cuts.begin(), cuts.end());
    double at = 0;
    for (const double cut : cuts) {
      const double middle = (at + cut) / 2;
      const auto jerk = [middle](const SpeedExtremal& e, const SpeedExtremal::Arc& m) {
        return e.sign * (middle < m.rise ? e.j_up : middle < m.rise + m.hold ? 0 : -e.j_down);
      };
      append(profile, cut - at, *part * jerk(rise, up) + (1 - *part) * jerk(fall, down));
      at = std::max(at, cut);
    }
    return true;
  }

 private:
  /// How much of the rising motion meets the speed in T; nothing: T is blocked.
  [[nodiscard]] std::optional<double> share(double t) const noexcept {
    const double ramp = (to_.a - inside_.a) / (to_.a >= inside_.a ? bounds_.j_max : bounds_.j_min);
    if (t < ramp) return std::nullopt;
    const SpeedExtremal rise(1, inside_, to_, bounds_), fall(-1, inside_, to_, bounds_);
    const double most = rise.gain(rise.arc(t)), least = -fall.gain(fall.arc(t)), wanted = to_.v - inside_.v;
    const double unsure = 1e-13 * (std::abs(to_.v) + std::abs(inside_.v) + std::abs(most) + std::abs(least));
    if (wanted > most + unsure || wanted < least - unsure) return std::nullopt;
    return most > least ? std::clamp((wanted - least) / (most - least), 0.0, 1.0) : 1.0;
  }

  Plan plan_;
  AxisBounds bounds_;
  State to_, inside_;
  Profile entered_;
  double entered_s_ = 0, shortest_s_ = 0;
};

}  // namespace

Joint change_speeds_together(std::span<const AxisMove> axes, const Together& how) noexcept {
  Joint out;
  if (check(axes, how, out))
    arrive<SpeedTrajectory>(axes, how, out, [](auto& trajectories, const AxisMove& m) -> SpeedTrajectory& {
      return trajectories.emplace_back(m);
    });
  return out;
}

}  // namespace gantry::motion
