// Plays segments from a ring, one tick (Limits::tick_s) a step: the tool is always on its path, every axis within its
// limits, and there is always a jerk-limited stop before the end of the path that is known.
//   Interpolator play(ring, limits, valve_bits);  play.start(q_now);  play.begin_block(7);
//   Setpoint p = play.step(override);             // every tick, also when idle
//   play.hold(); ... play.resume();               // effect from the next step on
// Nominal play evaluates s(t) of the segments as planned. Hold, override, starvation and their ends re-plan s alone.
// The consumer side of the ring is the interpolator's. Lives in the loop: no allocation, no lock.
#pragma once
#include <array>
#include <cstdint>

#include "core/rt/ring.hpp"
#include "motion/profile/planner.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

class Interpolator {
 public:
  using SegmentRing = rt::Ring<Segment, 1024>;

  /// valve_mask: bits of the output word that every hold and stop clears, and that only an OutputEvent with `dispense`
  /// sets again afterwards.
  Interpolator(SegmentRing& ring, const Limits& limits, std::uint32_t valve_mask) noexcept;

  /// Stands at q. Drops the block that plays, if any. Outputs stay, the valve is closed.
  void start(const AxisVec& q) noexcept;

  /// Plays the segments of `block`, from the next step on; segments of other blocks that are still in front are
  /// dropped. Only when idle.
  void begin_block(std::uint32_t block) noexcept;

  /// One tick on. override_factor: 0.1 .. 2.0, 1 = as planned; clamped.
  Setpoint step(double override_factor) noexcept;

  void hold() noexcept;           ///< brakes on the path; the valve closes at once
  void resume() noexcept;         ///< after hold or stop_path
  void stop_path() noexcept;      ///< like hold, for a fault
  void abort() noexcept;          ///< brakes on the path, then drops the rest of the block
  void probe_latched() noexcept;  ///< the probe has latched: brakes on the path, the block ends there
  void axis_stop() noexcept;      ///< every axis brakes with its own limits; the path is lost, the block is dropped

  /// Sets bits of the output word outside the valve's.
  void set_outputs(std::uint32_t mask, std::uint32_t bits) noexcept;

  [[nodiscard]] bool idle() const noexcept;      ///< no block plays
  [[nodiscard]] bool at_rest() const noexcept;   ///< the setpoint stands
  [[nodiscard]] bool held() const noexcept;      ///< hold or stop_path is in force
  [[nodiscard]] bool starving() const noexcept;  ///< slowed down because the block's next segments are not there
};

}  // namespace gantry::motion
