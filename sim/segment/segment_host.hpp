// What the virtual segment tells the world, and what the world may do to it. The segment asks nobody else: it knows
// stations, drives and motors.
#pragma once
#include <cstdint>

#include "core/clock.hpp"

namespace gantry::sim {

/// The world, as the segment sees it: called at every SYNC0 after all motors have moved to that instant and before
/// inputs are sampled.
class WorldHook {
 public:
  virtual ~WorldHook() = default;
  /// `cycle` counts SYNC0 events since the segment started; `now` is the instant on the machine's clock.
  virtual void on_sync(std::uint64_t cycle, Time now) noexcept = 0;
};

}  // namespace gantry::sim
