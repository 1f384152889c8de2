// What motion is made of. A Segment carries geometry q(s) and the part of a speed profile s(t) that plays on it;
// everything that happens meanwhile (hold, override, starvation) changes s(t) and leaves q(s) alone, so that the tool
// stays on its path. Plain values: they cross the RT boundary.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "core/axis_vec.hpp"
#include "core/rt/fixed_vector.hpp"

namespace gantry::motion {

/// Bounds of one axis in mm or rad.
struct AxisLimits {
  double p_min = 0, p_max = 0, v_max = 0, a_max = 0, j_max = 0;
};
struct Limits {
  std::array<AxisLimits, kMaxAxes> axis{};
  std::size_t axes = 0;                               ///< how many of them are used
  std::array<std::array<char, 16>, kMaxAxes> name{};  ///< for words, cut where it is longer
  std::array<bool, kMaxAxes> linear{};  ///< axes whose travel makes path length (X Y Z); others follow along
  double tick_s = 0.001;
  AxisVec response_delay_s{};  ///< how far each axis lags its target; who lags less is sent its target later
};

/// Duration rounded up to whole ticks; what is within rounding of a tick is that tick.
[[nodiscard]] inline double whole_ticks(double seconds, double tick_s) {
  return std::ceil(seconds / tick_s - 1e-9) * tick_s;
}

inline constexpr std::size_t kMaxPhases = 20;     ///< of one profile
inline constexpr std::size_t kSegmentPhases = 7;  ///< of a segment: as many as a move from rest to rest has
inline constexpr std::size_t kCoefficients = 18;  ///< of a segment's geometry: six axes on a cubic, or all on a line

/// Constant jerk for a while.
struct Phase {
  double duration_s = 0;
  double jerk = 0;
};

/// Position, speed and acceleration along a scalar.
struct State {
  double p = 0, v = 0, a = 0;
};

/// After a time at constant jerk.
[[nodiscard]] inline State advanced(const State& x, double jerk, double t) noexcept {
  return {x.p + t * (x.v + t * (x.a / 2 + t * jerk / 6)), x.v + t * (x.a + t * jerk / 2), x.a + t * jerk};
}

/// s(t) of one segment: starts at s = 0 with (v0, a0), then the phases.
struct SpeedProfile {
  double v0 = 0, a0 = 0;
  rt::FixedVector<Phase, kSegmentPhases> phases;
};

/// q(s): a standstill (degree 0), a line (1), or a part of a curve (3): a cubic in u, and u a quintic of arc length
/// (but for travel that is a cubic in time, path/arch.hpp, where u goes by evenly).
/// geometry.hpp makes and evaluates it.
struct Geometry {
  double length = 0;            ///< range of s: mm of path, or rad for rotary axes alone; of a dwell: seconds
  double begin = 0, whole = 0;  ///< of a curve: where this part begins on it, and its length
  std::array<double, 5> u{};    ///< of a curve: u = x (u[0] + u[1] x + ...), x = (begin + s) / whole
  AxisVec from{};               ///< q where u is 0
  std::uint16_t moving = 0;     ///< bit n: axis n moves
  std::uint8_t degree = 0;
  std::array<double, kCoefficients> c{};  ///< of u, u^2 ... u^degree for the first axis that moves, then the next
};

/// Outputs that switch where (or, on a dwell, when) the tool comes to a position. Fires at the first cycle tick at
/// which, by the current plan, s(now + lead + tick/2) >= at_s: exact on the planned ticks, within v * tick/2 under hold
/// and override.
struct OutputEvent {
  double at_s = 0;
  double lead_s = 0;                  ///< may reach back into earlier segments
  std::uint32_t mask = 0, value = 0;  ///< bits of the output word
  bool dispense = false;              ///< a new dispense command: the only thing that re-arms the valve after a stop
};

enum class SegmentKind : std::uint8_t {
  Path,   ///< a straight line from rest to rest: hold and override re-plan s on it
  Piece,  ///< of a longer path: begins and ends in motion, but for the first and the last; hold and override change
          ///< the rate at which its planned time is played
  Dwell,  ///< s counts seconds at rate 1; hold freezes it, override leaves it
  UntilProbe,  ///< ends where the probe latches; reaching its end without that is Fault::ProbeNeverTriggered
};

/// One piece of motion, as the planner hands it to the loop.
struct Segment {
  std::uint32_t block = 0;    ///< number of the block in the job, from 1
  std::uint32_t feature = 0;  ///< index of the recipe's feature, 0xFFFFFFFF for travel
  SegmentKind kind = SegmentKind::Path;
  bool ends_block = false;  ///< rest at its end, and the world is asked next
  bool rests = true;        ///< at its end by plan; false: the next one goes on with its speed and acceleration
  double v_cap = 0;         ///< path speed that the recipe wants at most (what 100 % means)
  rt::FixedVector<OutputEvent, 2> events;
  Geometry geometry;
  SpeedProfile nominal;  ///< what is played at override 1 without a stop
};

static_assert(sizeof(Segment) <= 600);

inline constexpr std::uint32_t kTravel = 0xFFFFFFFFu;

/// What the interpolator gives each tick.
struct Setpoint {
  AxisVec q{}, v{}, a{};
  std::uint32_t block = 0;          ///< 0: idle
  std::uint32_t tick_in_block = 0;  ///< counts from 1 while a block plays, also through holds
  std::uint32_t feature = kTravel;
  std::uint32_t outputs = 0;  ///< the output word that events have built
  double s = 0, s_dot = 0;
  double along_block_mm = 0;  ///< length of path from the start of the block's first segment; a dwell adds none
  bool moving = false;
  bool probing = false;     ///< this tick plays a segment of kind UntilProbe
  bool block_done = false;  ///< this tick reached the end of the block
  bool off_path = false;    ///< what was planned does not hold: every axis brakes by itself, and the path is lost
};

}  // namespace gantry::motion
