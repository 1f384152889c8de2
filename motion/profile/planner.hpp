// State-to-state motion of one axis (or of the path coordinate s), shortest in time under bounds on speed, acceleration
// and jerk. Several axes together: together.hpp.
//   Plan m = move({p0, v0, a0}, {p1, v1, a1}, {v, a, j});     // if (!m) -> m.reason
//   State x = evaluate(m.profile, t);                         // t beyond the end: the end state drifts on at its speed
//   Plan s = stop({p, v, a}, {v, a, j});
// Pure values, no allocation, bounded iterations: may run in the loop. Results do not depend on the unit of length.
#pragma once
#include <cstdint>
#include <limits>

#include "core/rt/fixed_vector.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

/// Symmetric bounds, all > 0 and finite: |v| <= v, |a| <= a, |jerk| <= j.
struct Bounds {
  double v = 0, a = 0, j = 0;
};

/// Bounds with a minimum and a maximum each: v_min, a_min, j_min < 0 < v_max, a_max, j_max, finite; p_min < p_max,
/// which may be infinite.
struct AxisBounds {
  double v_max = 0, v_min = 0, a_max = 0, a_min = 0, j_max = 0, j_min = 0;
  double p_min = -std::numeric_limits<double>::infinity(), p_max = std::numeric_limits<double>::infinity();

  constexpr AxisBounds() noexcept = default;
  constexpr AxisBounds(double vmax, double vmin, double amax, double amin, double jmax, double jmin) noexcept
      : v_max(vmax), v_min(vmin), a_max(amax), a_min(amin), j_max(jmax), j_min(jmin) {}
  /// Symmetric.
  constexpr AxisBounds(double v, double a, double j) noexcept : AxisBounds(v, -v, a, -a, j, -j) {}
  constexpr AxisBounds(const Bounds& b) noexcept : AxisBounds(b.v, b.a, b.j) {}
};

/// Constant-jerk phases from a start state.
struct Profile {
  State from;
  rt::FixedVector<Phase, kMaxPhases> phases;
};

enum class Reason : std::uint8_t {
  Solved,
  NotFinite,            ///< a number of the problem is nan or infinite
  BadBounds,            ///< a bound has the wrong sign or is 0
  TargetOutsideBounds,  ///< the target breaks a bound, or cannot be reached without breaking the speed bound before it
  StartCannotStay,      ///< the start is outside of the position limits, or hardest braking leaves them
  NoMotionWithin,       ///< no motion within the position limits was found
  NoSolution,           ///< numerically out of range (the problem's scales differ by more than doubles carry)
};
const char* name(Reason reason) noexcept;

/// What to do with a start outside of the bounds on speed and acceleration, or whose speed will leave them.
enum class Outside : std::uint8_t {
  Ease,     ///< to the bound, acceleration 0 there: no undershoot. For a bound lowered in motion.
  Soonest,  ///< back inside as soon as possible, whatever the speed does then
};

struct Plan {
  Reason reason = Reason::NoSolution;
  Profile profile;
  explicit operator bool() const noexcept { return reason == Reason::Solved; }
};

/// Position interface: shortest profile from `from` to `to`.
Plan move(const State& from, const State& to, const AxisBounds& bounds, Outside outside = Outside::Ease) noexcept;

/// Velocity interface: shortest profile from (v, a) to (v_to, a_to); where it ends follows. The bounds on v are not
/// used: both speeds are taken as given. A start beyond the acceleration bound comes back to it at full jerk first.
Plan change_speed(const State& from, double v_to, const AxisBounds& bounds, double a_to = 0) noexcept;

/// change_speed to 0.
Plan stop(const State& from, const AxisBounds& bounds) noexcept;

[[nodiscard]] double duration(const Profile& profile) noexcept;

/// State at time t >= 0 after the start.
[[nodiscard]] State evaluate(const Profile& profile, double t) noexcept;

/// State at the end.
[[nodiscard]] State end_state(const Profile& profile) noexcept;

/// Lowest and highest position of a motion.
struct Extent {
  double low = 0, high = 0;
};
[[nodiscard]] Extent extent(const Profile& profile) noexcept;

/// The same path in factor (>= 1) times the duration: speeds / factor, accelerations / factor^2, jerks / factor^3.
/// Start and end speeds scale as well, so that it is the same motion for what starts and ends at rest.
[[nodiscard]] Profile stretched(const Profile& profile, double factor) noexcept;

/// Length that a change from (v, 0) to (v_to, 0) takes, both >= 0.
[[nodiscard]] double change_length(double v, double v_to, double a, double j) noexcept;

/// Highest speed that (v, 0) can come to with acceleration 0 again over `length`; by symmetry also the highest speed
/// from which v can be braked to. Never above bounds.v unless v is.
[[nodiscard]] double speed_over_length(double v, double length, const Bounds& bounds) noexcept;

}  // namespace gantry::motion
