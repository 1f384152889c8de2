// A drive that brakes by itself, by a quick stop or in its own reaction to a fault, is believed as far as its position
// shows it: how far it has gone since, and whether that is farther than it may take.
//   braking.see(brakes, position, speed, reach.late_s, cycle_s);   each cycle that it was heard
//   if (braking.gone() > reach.of(braking.from_speed())) ...
// Pure state; lives in the RT loop.
#pragma once
#include <algorithm>
#include <cmath>
#include <utility>

namespace gantry::cycle {

/// What a drive may need to stand, in mm or rad.
struct BrakingReach {
  double deceleration = 0;  ///< per s^2, of its ramp, and no more than the axis's own
  double late_s = 0;        ///< until it decelerates by that: its delay, and what it was still accelerating
  double slack = 0;
  [[nodiscard]] double of(double speed) const noexcept {
    return speed * speed / (2 * deceleration) + speed * late_s + slack;
  }
};

class OwnBraking {
 public:
  /// `brakes`: it is to brake by itself in this cycle. Position in mm or rad, speed per s. Until `late_s` it may still
  /// become faster: it was accelerating, or catches up behind frames that were lost.
  void see(bool brakes, double position, double speed, double late_s, double cycle_s) noexcept {
    if (!brakes) {
      busy_ = false;
      return;
    }
    if (!std::exchange(busy_, true)) from_ = position, from_speed_ = since_s_ = 0;
    at_ = position;
    if (since_s_ <= late_s) from_speed_ = std::max(from_speed_, std::abs(speed));
    since_s_ += cycle_s;
  }
  [[nodiscard]] bool busy() const noexcept { return busy_; }
  [[nodiscard]] double gone() const noexcept { return std::abs(at_ - from_); }
  /// That it had when it began, or soon after.
  [[nodiscard]] double from_speed() const noexcept { return from_speed_; }

 private:
  double from_ = 0, at_ = 0, from_speed_ = 0, since_s_ = 0;
  bool busy_ = false;
};

}  // namespace gantry::cycle
