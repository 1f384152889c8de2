// When the cycles are due. The phase is kept whatever happens: after a stall the next beat says how many periods have
// passed, and the loop goes on from there; cycles are never sent in a burst to catch up. A clock that stands still with
// its host loses no period: the beat says for how many it stood.
//   Pacer pacer(start, period);   Beat b = pacer.wait(clock);   loop.tick(b);
#pragma once
#include <algorithm>

#include "core/clock.hpp"
#include "core/id.hpp"

namespace gantry::cycle {

struct Beat {
  CycleIndex cycle = 0;      ///< number of this cycle; cycles that were slept through are skipped
  std::int64_t elapsed = 1;  ///< periods since the last beat: 1 unless the host stalled
  Time due{};                ///< when this cycle was due
  Time woke{};               ///< when the loop woke for it
  std::int64_t still = 0;    ///< periods of the host's for which the machine's own time stood still before this beat
};

class Pacer {
 public:
  Pacer(Time first, Time period) noexcept : due_(first), period_(period) {}

  /// Sleeps until the next cycle is due.
  Beat wait(Clock& clock) noexcept {
    const Time asleep_at = std::max(clock.now(), due_);
    clock.sleep_until(due_);
    Time woke = clock.now();
    // What passes between two beats besides the sleep has passed for the bus, too.
    std::int64_t still = woke > asleep_at ? (woke - asleep_at) / period_ : 0;
    if (still > 0 && clock.stand_still(still * period_))
      woke -= still * period_;
    else
      still = 0;
    const std::int64_t slept_through = woke > due_ ? (woke - due_) / period_ : 0;
    cycle_ += 1 + slept_through;
    const Beat beat{cycle_, 1 + slept_through, due_ + slept_through * period_, woke, still};
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
