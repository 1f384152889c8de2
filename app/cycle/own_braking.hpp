// A drive that brakes by itself, by a quick stop or in its own reaction to a fault, is believed as far as its position
// shows it: how far it has gone since, and whether that is farther than it may take.
//   braking.see(brakes, position, speed, catches_up, cycle_s, reach);   each cycle that it was heard
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
  double gains = 0;  ///< per s: by so much it may still become faster than it was when it was told
  [[nodiscard]] double of(double speed) const noexcept {
    return speed * speed / (2 * deceleration) + speed * late_s + slack;
  }
};

class OwnBraking {
 public:
  /// `brakes`: it is to brake by itself in this cycle. Position in mm or rad, speed per s. `catches_up`: frames were
  /// lost, and it may be as fast as it takes to where it was sent meanwhile.
  void see(bool brakes, double position, double speed, bool catches_up, double cycle_s,
           const BrakingReach& reach) noexcept {
    constexpr double kOfItsSpeed_s = 0.003;  // one cycle may show nothing, and the next one twice
    if (!brakes) {
      busy_ = false;
      return;
    }
    if (!std::exchange(busy_, true)) from_ = position, gone_ = at_first_ = from_speed_ = since_s_ = 0;
    gone_ = std::max(gone_, std::abs(position - from_));
    if (since_s_ < kOfItsSpeed_s || catches_up) at_first_ = std::max(at_first_, std::abs(speed));
    if (since_s_ <= reach.late_s)
      from_speed_ = std::max(from_speed_, std::min(std::abs(speed), at_first_ + reach.gains));
    since_s_ += cycle_s;
  }
  [[nodiscard]] bool busy() const noexcept { return busy_; }
  /// At most.
  [[nodiscard]] double gone() const noexcept { return gone_; }
  /// That it had when it began, or soon after.
  [[nodiscard]] double from_speed() const noexcept { return from_speed_; }

 private:
  double from_ = 0, gone_ = 0, at_first_ = 0, from_speed_ = 0, since_s_ = 0;
  bool busy_ = false;
};

}  // namespace gantry::cycle
