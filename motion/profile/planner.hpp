// State-to-state motion of one axis (or of the path coordinate s), shortest in time under bounds on speed, acceleration
// and jerk.
//   Plan m = move({p0, v0, a0}, {p1, v1, a1}, {v, a, j});     // if (!m) -> m.reason
//   State x = evaluate(m.profile, t);                         // t beyond the end: the end state drifts on at its speed
//   Plan s = stop({p, v, a}, {v, a, j});
// Pure values, no allocation, bounded iterations: may run in the loop. Results do not depend on the unit of length.
#pragma once
#include <cstdint>

#include "core/rt/fixed_vector.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

/// Symmetric bounds, all > 0 and finite: |v| <= v, |a| <= a, |jerk| <= j.
struct Bounds {
  double v = 0, a = 0, j = 0;
};

/// Constant-jerk phases from a start state.
struct Profile {
  State from;
  rt::FixedVector<Phase, 12> phases;
};

enum class Reason : std::uint8_t {
  Solved,
  NotFinite,            ///< a number of the problem is nan or infinite
  BadBounds,            ///< a bound is not > 0
  TargetOutsideBounds,  ///< the target breaks a bound, or cannot be reached without breaking the speed bound before it
  NoSolution,           ///< numerically out of range (the problem's scales differ by more than doubles carry)
};
const char* name(Reason reason) noexcept;

struct Plan {
  Reason reason = Reason::NoSolution;
  Profile profile;
  explicit operator bool() const noexcept { return reason == Reason::Solved; }
};

/// Position interface: shortest profile from `from` to `to`. A start outside the bounds, or one whose speed bound
/// cannot be kept, first eases to the bound by change_speed (no undershoot), and goes on from there.
Plan move(const State& from, const State& to, const Bounds& bounds) noexcept;

/// Velocity interface: shortest profile from (v, a) to (v_to, 0); where it ends follows. bounds.v is not used: both
/// speeds are taken as given. A start beyond the acceleration bound comes back to it at full jerk first.
Plan change_speed(const State& from, double v_to, const Bounds& bounds) noexcept;

/// change_speed to 0.
Plan stop(const State& from, const Bounds& bounds) noexcept;

[[nodiscard]] double duration(const Profile& profile) noexcept;

/// State at time t >= 0 after the start.
[[nodiscard]] State evaluate(const Profile& profile, double t) noexcept;

/// State at the end.
[[nodiscard]] State end_state(const Profile& profile) noexcept;

/// The same way in factor (>= 1) times the duration: speeds / factor, accelerations / factor^2, jerks / factor^3. Start
/// and end speeds scale as well, so that it is the same motion for what starts and ends at rest.
[[nodiscard]] Profile stretched(const Profile& profile, double factor) noexcept;

/// Length that a change from (v, 0) to (v_to, 0) takes, both >= 0.
[[nodiscard]] double change_length(double v, double v_to, double a, double j) noexcept;

/// Highest speed that (v, 0) can come to with acceleration 0 again over `length`; by symmetry also the highest speed
/// from which v can be braked to. Never above bounds.v unless v is.
[[nodiscard]] double speed_over_length(double v, double length, const Bounds& bounds) noexcept;

}  // namespace gantry::motion
