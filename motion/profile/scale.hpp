// From one axis's units to the scaled problem and back.
#pragma once
#include <optional>

#include "motion/profile/planner.hpp"
#include "motion/profile/reachable.hpp"

namespace gantry::motion {

// Two states closer than this, relative to the scales of the problem, are one: below what an end state is asked for
// (1e-9), above what positions and bounds carry as doubles.
inline constexpr double kSame = 1e-12;
// A ramp that ends closer to the target, relative to the same scales, leads there.
inline constexpr double kOnRamp = 1e-11;
// What a position of the problem is uncertain by, of its scale: a little more than rounding.
inline constexpr double kResolution = 1e-13;
// Durations that differ by less, relatively, are one.
inline constexpr double kEqual = 1e-13;
// A bound overstepped by less is met.
inline constexpr double kSlack = 1e-11;

struct Scale {
  double t = 1, v = 1, p = 1, a = 1, j = 1;
  scaled::Box box;

  explicit Scale(const AxisBounds& bounds) noexcept;
  [[nodiscard]] scaled::Ends ends(const State& from, const State& to) const noexcept;
};

/// What positions of this problem are measured by: where the ends lie, and how far the faster of them takes to stop.
[[nodiscard]] double position_scale(const State& from, const State& to, const AxisBounds& bounds) noexcept;

/// One phase, or none, that leads to the target but for rounding: where the target is the start, or lies on a ramp at
/// full jerk from it, as it does for whoever plans anew in the last phase. Rounding must not ask for a detour there.
/// `before`: what has led to the start; with it the motion keeps the position limits, or it is none.
[[nodiscard]] std::optional<Phase> one_ramp(const Profile& before, const State& from, const State& to,
                                            const AxisBounds& bounds) noexcept;

/// Speed that (v, a) comes to when the acceleration is taken out at full jerk; with `time_sign` -1: came from.
[[nodiscard]] double coming_speed(const State& x, const AxisBounds& bounds, int time_sign = 1) noexcept;

[[nodiscard]] Reason problem_of(const State& x, const AxisBounds& bounds) noexcept;
/// The target within the bounds, and every speed before it.
[[nodiscard]] Reason problem_of_target(const State& to, const AxisBounds& bounds) noexcept;

/// Appends what brings a start inside the bounds and gives the state there.
[[nodiscard]] State enter(const State& from, const AxisBounds& bounds, Outside outside, Profile& profile) noexcept;

/// Shortest motion from a state inside the bounds, without position limits; appended to the profile.
[[nodiscard]] Reason append_shortest(const State& from, const State& to, const AxisBounds& bounds, Profile& profile,
                                     double resolution) noexcept;

/// The profile ends at the target, within 1e-9 of the problem's scales; `scale_p` is position_scale(). A start that was
/// `outside` of the bounds may be carried far away first: what rounding over the long path back leaves of the target is
/// then taken out of the coasting phase, and the end is judged by start, target and bounds alone. So is that of a
/// motion so long that rounding would show at its end, which has to keep its bounds on speed, too.
[[nodiscard]] bool arrives(Profile& profile, const State& to, const AxisBounds& bounds, double scale_p,
                           bool outside) noexcept;

inline void append(Profile& profile, double duration_s, double jerk) noexcept {
  if (duration_s > 0) profile.phases.push_back({duration_s, jerk});
}
/// Phases of a scaled shape.
void append(Profile& profile, const scaled::Shape& shape, const Scale& scale) noexcept;

/// share * up + (1 - share) * down.
void append(Profile& profile, const scaled::Mix& mix, const Scale& scale) noexcept;

/// Shortest motion that stays within bounds.p_min .. p_max, from a state inside the bounds; appended.
[[nodiscard]] Reason append_between_walls(const State& from, const State& to, const AxisBounds& bounds,
                                          Profile& profile, double resolution) noexcept;

}  // namespace gantry::motion
