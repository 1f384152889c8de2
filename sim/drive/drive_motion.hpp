// What a virtual drive makes of its motor: a command that stands, follows the targets of CSP, or runs at a speed, and
// the counter that tells where it is.
//   motion.follow(target_counts, cycle_s);                       // straight to the target in one cycle
//   double left = dt_s;
//   while (auto changed = motion.advance(left, watch)) { ... }   // stops at the instant of every watched edge
// Speeds and counts run in the drive's own direction; limit switches are those of that direction, too.
#pragma once
#include <cstdint>

#include "sim/drive/motor.hpp"

namespace gantry::sim {

class DriveMotion {
 public:
  /// `invert`: counts rise while the axis coordinate falls. Open loop: the counter tells the command, not the motor.
  DriveMotion(Motor& motor, double counts_per_unit, bool invert, bool closed_loop) noexcept;

  /// The counter reads 0 where the motor stands.
  void power_on() noexcept;

  void hold() noexcept;
  /// No torque: the motor runs out by itself, until anchor().
  void let_go() noexcept;
  [[nodiscard]] bool is_free() const noexcept { return mode_ == Mode::Free; }
  void follow(std::int64_t target_counts, double span_s) noexcept;
  /// A limit keeps the command from the last target of follow().
  [[nodiscard]] bool held_back() const noexcept { return held_back_; }
  /// Speeds up or down to `counts_s` and keeps it. No acceleration given: at once.
  void run(double counts_s, double counts_s2) noexcept;
  void brake(double counts_s2) noexcept { run(0, counts_s2); }
  /// A limit: stops at once and lets the command pass no farther in that direction, until release().
  void block(int direction) noexcept;
  void release(int direction) noexcept;
  /// The command begins anew where the motor is. An open-loop drive does not notice: its counter stays.
  void anchor() noexcept;
  /// Without torque for so long: the axis goes where a brake that does not hold lets it go.
  void slip(double span_s) noexcept;
  /// Moves for `left_s` at most. Inputs that changed (MotorInput, drive's view), with what is left; 0 at the end.
  std::uint32_t advance(double& left_s, std::uint32_t watch) noexcept;

  /// Switches and probe now.
  [[nodiscard]] std::uint32_t inputs() const noexcept { return view(motor_->inputs()); }
  [[nodiscard]] std::int64_t counts() const noexcept;  ///< as 6064h has it, before it wraps
  [[nodiscard]] std::int64_t demand() const noexcept;  ///< the command in counts
  [[nodiscard]] double speed() const noexcept;         ///< counts/s
  [[nodiscard]] double deviation() const noexcept;     ///< counts between command and motor
  [[nodiscard]] bool commands_motion() const noexcept { return speed_ != 0 || goal_ != 0; }
  /// From here on this position has the count `counts`.
  void set_counts(std::int64_t counts) noexcept;

  [[nodiscard]] double count_zero() const noexcept { return sign_ * zero_; }  ///< axis coordinate
  void restore(double position, double count_zero) noexcept;

 private:
  enum class Mode : std::uint8_t { Hold, Follow, Run, Free };
  [[nodiscard]] std::uint32_t view(std::uint32_t inputs) const noexcept;
  [[nodiscard]] double position() const noexcept;  ///< what the counter counts, in units of the axis, drive's direction

  Motor* motor_;
  double counts_per_unit_, sign_;
  bool closed_loop_;
  Mode mode_ = Mode::Hold;
  // In units of the axis, along the drive's direction.
  double at_ = 0, speed_ = 0;   ///< command
  double goal_ = 0, rate_ = 0;  ///< Run: speed and acceleration
  double to_ = 0, left_s_ = 0;  ///< Follow: end and time to it
  bool held_back_ = false;
  double zero_ = 0;                         ///< position of count 0
  double lowest_ = -1e18, highest_ = 1e18;  ///< where limits hold the command
};

}  // namespace gantry::sim
