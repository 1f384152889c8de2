// How far the two sides of a beam stand apart when they take torque: pushed without it, or relaxed. Enabling moves
// neither; the next motion of the axis takes the difference out, smoothly.
//   each cycle: lean.see(first, second, takers);   lean.step(moves, speed, period, elapsed);
//   target of a side = that of the axis + lean.of(side)
// Pure state; lives in the RT loop.
#pragma once
#include <algorithm>
#include <cstdint>

#include "app/cycle/squaring.hpp"
#include "core/clock.hpp"

namespace gantry::cycle {

class Lean {
 public:
  /// Coordinates of the sides, mm or rad, and how many of them take targets. From when both do until neither does they
  /// are held, and how far they stand apart is no longer what is seen.
  void see(double first, double second, int takers) noexcept {
    if (takers != 1) held_ = takers == 2;
    if (!held_) apart_ = second - first, ramp_ = {};
  }
  /// Homing squares them.
  void forget() noexcept { apart_ = 0, ramp_ = {}; }
  /// What side 0 or 1 is off the axis's coordinate, which is their mean.
  [[nodiscard]] double of(std::size_t side) const noexcept { return side == 0 ? -apart_ / 2 : apart_ / 2; }
  /// `moves`: the axis does in this cycle. Neither side by more than half of `speed_per_s` besides.
  void step(bool moves, double speed_per_s, Time period, std::int64_t elapsed) noexcept {
    if (!moves) ramp_ = {};
    if (!moves || apart_ == 0) return;
    if (!ramp_.busy()) ramp_.start(apart_, 0, speed_per_s, period);
    for (std::int64_t i = 0; i < elapsed && ramp_.busy(); ++i) apart_ = ramp_.step();
    if (!ramp_.busy()) forget();
  }

 private:
  double apart_ = 0;
  bool held_ = false;
  Squaring ramp_;
};

}  // namespace gantry::cycle
