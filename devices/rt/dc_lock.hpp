// Locks the loop's cycle to the reference clock: a PI on the phase at which the cyclic frame passes the first station.
//   DcLock lock(dc_lock_options(cycle));
//   next_wake += cycle + lock.step(exchange.reference_ns);     if (lock.locked()) ...
// Pure function of its samples; lives in the RT loop.
#pragma once
#include <cstdint>

#include "core/clock.hpp"

namespace gantry::devices {

struct DcLockOptions {
  Time cycle = milliseconds(1);
  /// Wanted DC time, modulo the cycle, at which the frame passes: SYNC0 is on whole cycles of DC time, so half a cycle
  /// leaves the outputs half a cycle to arrive, and the inputs half a cycle to be ready.
  Time phase = microseconds(500);
  /// Gains per cycle. Poles of z^2 - (2 - kp) z + (1 - kp + ki): 0.928 and 0.972, no overshoot, settled in about 100
  /// cycles.
  double kp = 0.1, ki = 0.002;
  Time correction_max = microseconds(10);  ///< of one cycle
  Time rate_max = microseconds(1);         ///< of the integral: 1000 ppm of a 1 ms cycle
  /// A sample this far from the last one that was used is of a frame that the host sent late, and is not used ...
  Time outlier = microseconds(50);
  int believed_after = 10;  ///< ... unless so many in a row say that the phase has changed

  // locked(), with hysteresis. A frame counts as lost when it is not back two fifths of a cycle after it was due, and
  // SYNC0 comes half a cycle after: with more than the tenth between them, a frame that is still taken may meet SYNC0,
  // and stations see two or no targets in a cycle. Half of that bound has to be kept first, so that noise about one
  // bound does not change the answer in every cycle.
  Time lock_below = microseconds(50);  ///< phase error that samples have to keep ...
  int lock_after = 100;                ///< ... so many in a row: as long as the loop takes to settle, no mere pass
  Time unlock_beyond = microseconds(100);
  int unlock_after = 10;  ///< samples in a row; a single one may be a frame that was late
  /// Cycles without a sample that was used, after which nothing is known of the phase: two quartzes that are 100 ppm
  /// apart drift by the tenth of a cycle in so many.
  int unknown_after = 1000;
};

/// For a cycle of this length: half a cycle of phase, and everything that is a part of a cycle in proportion.
constexpr DcLockOptions dc_lock_options(Time cycle) noexcept {
  return {.cycle = cycle,
          .phase = cycle / 2,
          .correction_max = cycle / 100,
          .rate_max = cycle / 1000,
          .outlier = cycle / 20,
          .lock_below = cycle / 20,
          .unlock_beyond = cycle / 10};
}

class DcLock {
 public:
  explicit DcLock(const DcLockOptions& options = {}) noexcept : options_(options) {}

  /// What to add to the next cycle. dc_time_ns 0: no sample in this cycle, the learnt rate goes on.
  Time step(std::uint64_t dc_time_ns) noexcept;
  /// Phase error of the last sample that was used: > 0 when the frame passes too late.
  [[nodiscard]] Time error() const noexcept { return Time{error_ns_}; }
  /// The cycle keeps its distance from SYNC0, and has for a while. False also for as long as there is no reference
  /// clock: whether there is one is for the caller to know.
  [[nodiscard]] bool locked() const noexcept { return locked_; }

 private:
  DcLockOptions options_;
  [[nodiscard]] bool is_outlier(std::int64_t error_ns) noexcept;
  void judge_lock(bool used) noexcept;

  std::int64_t error_ns_ = 0;
  bool any_used_ = false;
  int outliers_ = 0;  ///< in a row
  double integral_ns_ = 0, fraction_ns_ = 0;
  bool locked_ = false;
  int against_ = 0;  ///< samples in a row that speak against locked_
  int silent_ = 0;   ///< cycles in a row without a sample that was used
};

}  // namespace gantry::devices
