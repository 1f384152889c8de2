// Locks the loop's cycle to the reference clock: a PI on the phase at which the cyclic frame passes the first station.
//   DcLock lock({.cycle = milliseconds(1), .phase = microseconds(500)});
//   next_wake += cycle + lock.step(exchange.dc_time_ns);
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
};

class DcLock {
 public:
  explicit DcLock(const DcLockOptions& options = {}) noexcept : options_(options) {}

  /// What to add to the next cycle. dc_time_ns 0: no sample in this cycle, the learnt rate goes on.
  Time step(std::uint64_t dc_time_ns) noexcept;
  /// Phase error of the last sample that was used: > 0 when the frame passes too late.
  [[nodiscard]] Time error() const noexcept { return Time{error_ns_}; }

 private:
  DcLockOptions options_;
  [[nodiscard]] bool is_outlier(std::int64_t error_ns) noexcept;

  std::int64_t error_ns_ = 0;
  bool any_used_ = false;
  int outliers_ = 0;  ///< in a row
  double integral_ns_ = 0, fraction_ns_ = 0;
};

}  // namespace gantry::devices
