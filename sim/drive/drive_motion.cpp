#include "sim/drive/drive_motion.hpp"

#include <algorithm>
#include <cmath>

#include "sim/whole.hpp"

namespace gantry::sim {
namespace {
constexpr double kNoTime_s = 1e-12, kFarAway = 1e18;
}

DriveMotion::DriveMotion(Motor& motor, double counts_per_unit, bool invert, bool closed_loop) noexcept
    : motor_(&motor), counts_per_unit_(counts_per_unit), sign_(invert ? -1 : 1), closed_loop_(closed_loop) {
  power_on();
}

void DriveMotion::power_on() noexcept {
  at_ = zero_ = sign_ * motor_->position();
  lowest_ = -kFarAway, highest_ = kFarAway;
  mode_ = Mode::Hold;
  hold();
}

void DriveMotion::restore(double position, double count_zero) noexcept {
  motor_->restore(position);
  power_on();
  zero_ = sign_ * count_zero;
}

void DriveMotion::hold() noexcept {
  if (mode_ != Mode::Free) mode_ = Mode::Hold;
  speed_ = goal_ = 0;
}

void DriveMotion::let_go() noexcept {
  hold();
  if (motor_->runs_out() && motor_->velocity() != 0)
    mode_ = Mode::Free;
  else
    anchor();  // without torque nothing draws it to where it was told to be
}

void DriveMotion::follow(std::int64_t target, double span_s) noexcept {
  const double wanted = zero_ + static_cast<double>(target) / counts_per_unit_;
  to_ = std::clamp(wanted, lowest_, highest_);
  held_back_ = to_ != wanted;
  if (to_ == at_) return hold();
  mode_ = Mode::Follow;
  left_s_ = span_s;
  speed_ = (to_ - at_) / span_s;
}

void DriveMotion::run(double counts_s, double counts_s2) noexcept {
  if (mode_ == Mode::Free) return;
  mode_ = Mode::Run;
  goal_ = counts_s / counts_per_unit_;
  rate_ = counts_s2 / counts_per_unit_;
  if (rate_ <= 0) speed_ = goal_;
  if (speed_ == 0 && goal_ == 0) hold();
}

void DriveMotion::block(int direction) noexcept {
  if (speed_ * direction > 0) hold();
  if (direction > 0) highest_ = std::min(highest_, at_);
  if (direction < 0) lowest_ = std::max(lowest_, at_);
}

void DriveMotion::release(int direction) noexcept {
  if (direction > 0) highest_ = kFarAway;
  if (direction < 0) lowest_ = -kFarAway;
}

void DriveMotion::anchor() noexcept {
  const double here = sign_ * motor_->position();
  if (!closed_loop_) zero_ += here - at_;
  at_ = here;
  mode_ = Mode::Hold;
  hold();
}

void DriveMotion::slip(double span_s) noexcept {
  if (motor_->slipping() == 0) return;
  motor_->restore(motor_->position() + motor_->slipping() * span_s);
  anchor();
}

std::uint32_t DriveMotion::advance(double& left_s, std::uint32_t watch) noexcept {
  while (left_s > kNoTime_s) {
    if (mode_ == Mode::Free) {
      const Ran ran = motor_->coast(left_s, view(watch));
      left_s -= ran.elapsed_s;
      if (closed_loop_) at_ = sign_ * motor_->position();  // an open-loop counter stays at what was commanded last
      if (ran.changed != 0) return view(ran.changed);
      continue;
    }
    CommandPiece piece{at_, 0, 0};
    double span = left_s;
    if (mode_ == Mode::Hold) {
      speed_ = 0;
    } else if (mode_ == Mode::Follow) {
      piece.v = speed_;
      span = std::min(span, left_s_);
    } else if (mode_ == Mode::Run) {
      piece.v = speed_;
      if (speed_ != goal_) {
        piece.a = std::copysign(rate_, goal_ - speed_);
        span = std::min(span, (goal_ - speed_) / piece.a);
      }
    }
    const CommandPiece command{sign_ * piece.p, sign_ * piece.v, sign_ * piece.a};
    const Ran ran = motor_->run(command, span, view(watch));
    const double t = ran.elapsed_s;
    const bool whole = t >= span;
    at_ += (piece.v + 0.5 * piece.a * t) * t;
    left_s -= t;
    if (mode_ == Mode::Follow) {
      left_s_ -= t;
      if (left_s_ <= kNoTime_s) {
        at_ = to_;           // exactly, so that a standing target stands exactly
        mode_ = Mode::Hold;  // at speed: what comes now may go on from it
      }
    } else if (mode_ == Mode::Run) {
      const bool arrived = whole && piece.a != 0 && span < left_s + t;
      speed_ = arrived ? goal_ : speed_ + piece.a * t;
      if (speed_ == 0 && goal_ == 0) hold();
    }
    if (ran.changed != 0) return view(ran.changed);
  }
  left_s = 0;
  return 0;
}

std::uint32_t DriveMotion::view(std::uint32_t inputs) const noexcept {
  if (sign_ > 0) return inputs;
  const std::uint32_t others = inputs & ~(kNegLimit | kPosLimit);
  return others | ((inputs & kNegLimit) != 0 ? kPosLimit : 0u) | ((inputs & kPosLimit) != 0 ? kNegLimit : 0u);
}

double DriveMotion::position() const noexcept { return closed_loop_ ? sign_ * motor_->position() : at_; }

std::int64_t DriveMotion::counts() const noexcept { return whole((position() - zero_) * counts_per_unit_); }

std::int64_t DriveMotion::demand() const noexcept { return whole((at_ - zero_) * counts_per_unit_); }

double DriveMotion::speed() const noexcept {
  return (closed_loop_ ? sign_ * motor_->velocity() : speed_) * counts_per_unit_;
}

double DriveMotion::deviation() const noexcept { return (at_ - sign_ * motor_->position()) * counts_per_unit_; }

void DriveMotion::set_counts(std::int64_t counts) noexcept {
  zero_ = position() - static_cast<double>(counts) / counts_per_unit_;
}

}  // namespace gantry::sim
