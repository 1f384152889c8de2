// What the drives were last sent, and for how long it stood. A host that stalls leaves the drives at the old target and
// then sends one that is far ahead: until they had time to catch up, an axis that is anywhere between the two follows.
//   sent.push(elapsed, targets);                              // every cycle
//   sent.behind(axis, position, 10)                           // what counts as following error
//   sent.beyond(axis, position, 10)                           // what no delay explains; RT
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/id.hpp"
#include "motion/types.hpp"

namespace gantry::cycle {

class SentTargets {
 public:
  static constexpr std::int64_t kMostCycles = 255;  ///< that are looked back

  /// `elapsed`: cycles since the last call; more than 1 after a stall.
  void push(std::int64_t elapsed, const AxisVec& target) noexcept {
    now_ += elapsed;
    if (elapsed > 1) last_stall_ = now_;
    newest_ = (newest_ + 1) % ring_.size();
    ring_[newest_] = {now_, target};
  }

  /// Last target minus `position`. Where a stall ended within the last `cycles` cycles (at most kMostCycles), the
  /// distance from all that stood within them: 0 between the lowest and the highest.
  [[nodiscard]] double behind(AxisId axis, double position, std::int64_t cycles) const noexcept {
    if (last_stall_ < now_ - std::min(cycles, kMostCycles)) return target(axis) - position;
    return beyond(axis, position, cycles);
  }

  /// From `position` to the nearest of all targets that stood within the last `cycles` cycles (at most kMostCycles): 0
  /// between the lowest and the highest.
  [[nodiscard]] double beyond(AxisId axis, double position, std::int64_t cycles) const noexcept {
    const std::int64_t since = now_ - std::min(cycles, kMostCycles);
    double low = target(axis), high = low;
    // The last one that was sent before `since` still stood then.
    for (std::size_t i = newest_, n = 1; n < ring_.size() && ring_[i].cycle > since; ++n) {
      i = (i + ring_.size() - 1) % ring_.size();
      low = std::min(low, ring_[i].target[axis.value]);
      high = std::max(high, ring_[i].target[axis.value]);
    }
    return position < low ? low - position : position > high ? high - position : 0;
  }

  [[nodiscard]] double target(AxisId axis) const noexcept { return ring_[newest_].target[axis.value]; }

 private:
  struct Sent {
    std::int64_t cycle = 0;
    AxisVec target{};
  };
  std::array<Sent, kMostCycles + 2> ring_{};
  std::size_t newest_ = 0;
  std::int64_t now_ = 0, last_stall_ = -2 * kMostCycles;
};

}  // namespace gantry::cycle
