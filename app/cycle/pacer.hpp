// When the cycles are due. The phase is kept whatever happens: after a stall the next beat says how many periods have
// passed, and the loop goes on from there; cycles are never sent in a burst to catch up.
//   Pacer pacer(start, period);   Beat b = pacer.wait(clock);   loop.tick(b);
#pragma once
#include "core/clock.hpp"
#include "core/id.hpp"

namespace gantry::cycle {

struct Beat {
  CycleIndex cycle = 0;      ///< number of this cycle; cycles that were slept through are skipped
  std::int64_t elapsed = 1;  ///< periods since the last beat: 1 unless the host stalled
  Time due{};                ///< when this cycle was due
  Time woke{};               ///< when the loop woke for it
};

class Pacer {
 public:
  Pacer(Time first, Time period) noexcept : due_(first), period_(period) {}

  /// Sleeps until the next cycle is due.
  Beat wait(Clock& clock) noexcept {
    clock.sleep_until(due_);
    const Time woke = clock.now();
    const std::int64_t slept_through = woke > due_ ? (woke - due_) / period_ : 0;
    cycle_ += 1 + slept_through;
    const Beat beat{cycle_, 1 + slept_through, due_ + slept_through * period_, woke};
    due_ = beat.due + period_;
    return beat;
  }

  /// Moves the coming cycles a little: the lock to the bus's reference clock.
  void shift(Time by) noexcept { due_ += by; }
  [[nodiscard]] Time period() const noexcept { return period_; }

 private:
  Time due_, period_;
  CycleIndex cycle_ = 0;
};

}  // namespace gantry::cycle
