// What takes several cycles: probing, enabling, resetting, homing, blocks. Looked at in every cycle, answered when
// over.
#include <cmath>
#include <utility>

#include "app/cycle/loop.hpp"

namespace gantry::cycle {

using devices::DriveGoal;

namespace {
constexpr Time kResetTimeout = milliseconds(500);  // for the drives to leave their fault state
constexpr Time kStopTimeout = milliseconds(3000);  // for axes to stand before their torque is taken
}  // namespace

/// Without an armed probe nothing would end the approach.
void Loop::watch_approach() noexcept {
  using Probe = devices::ProbeArm::Phase;
  const Probe probe = axes_.probe().phase();
  probing_ = probe == Probe::Armed;
  if (probing_) return;
  probe_over_ = true;
  react(probe == Probe::Latched ? Fault::ProbeImplausible : Fault::ProbeStale, setup_.probe_axis, 0);
}

void Loop::disarm(Fault why) noexcept {
  axes_.probe().stop();
  answer(std::exchange(pending_probe_, 0), why, setup_.probe_axis);
}

void Loop::follow_probe() noexcept {
  using Probe = devices::ProbeArm::Phase;
  const Probe probe = axes_.probe().phase();
  if (pending_probe_ != 0 && (probe == Probe::Armed || probe == Probe::Failed)) {
    answer(pending_probe_, probe == Probe::Armed ? Fault::None : axes_.probe().fault(), setup_.probe_axis);
    pending_probe_ = 0;
  }
  if (probe == Probe::Latched && !probe_told_) {
    probe_told_ = true;
    // An axis that stands meets no surface; one that a hold has stopped comes to stand by its delay later.
    if (probing_ && !(state_ == State::Held && axes_.standing()) && latched_nearby()) {
      interpolator_.probe_latched(setup_.probe_axis, axes_.probe_position());
      tell({.kind = EventKind::Touched, .axis = setup_.probe_axis, .block = block_, .value = axes_.probe_position()});
    } else {
      react(Fault::ProbeImplausible, setup_.probe_axis, 0);
    }
  }
  if (probe == Probe::Failed && probing_) react(axes_.probe().fault(), setup_.probe_axis, 0);
  if (probe != Probe::Latched) probe_told_ = false;
  if (probing_ && probe != Probe::Armed) probing_ = false, probe_over_ = true;
}

/// Everything that takes several cycles and is now over.
void Loop::follow_progress() noexcept {
  follow_braking();
  follow_stop();
  follow_kept_torque();
  follow_probe();
  const bool rests = interpolator_.at_rest() && settled_;
  switch (state_) {
    case State::Offline:
      if (exchange_.fault == Fault::None && exchange_.operational)
        change(latched_ == Fault::None ? Cause::Operational : Cause::OperationalLatched);
      hold_position();
      break;
    case State::Disabled:
    case State::Disabling:
    case State::Stopped:
      if (!axes_.all_enabled()) hold_position();
      break;
    case State::Enabling:
      hold_position();
      if (axes_.all_enabled() && brake_open()) change(Cause::TorqueOn), answer_pending(Fault::None);
      break;
    case State::Homing:
      axes_.follow_homing();
      watch_homing();
      if (!axes_.homing()) finish_homing();
      break;
    case State::Running:
    case State::Stopping:
      if (rests && interpolator_.idle()) finish_block();
      break;
    case State::Holding:
      if (rests && !hold_waits_) change(Cause::Rest);
      break;
    case State::Ready:
    case State::Held: break;
  }
  if (pending_reset_ != 0) finish_reset();
  if (axes_.all_disabled()) {
    change(Cause::TorqueOff);
    answer(std::exchange(pending_disable_, 0), Fault::None);
  }
}

/// Nothing is commanded to move, and every drive with torque was heard to stand.
bool Loop::at_rest() const noexcept {
  return interpolator_.at_rest() && settled_ && !axes_.homing() && axes_.standing();
}

/// Stop category 1: the axes are braked (by the drives whose quick stop does, the others by their targets); when all of
/// them stand, or after a time-out, the brake closes, and then the torque goes.
void Loop::follow_stop() noexcept {
  if (axes_.goal() == DriveGoal::QuickStop && !taking_torque_) {
    const bool rests = at_rest();
    const bool over = !rests && ++stop_ticks_ * setup_.period > kStopTimeout;
    if (over) tell_moving();
    if (rests || over) take_torque();
  }
  if (!taking_torque_ || ++brake_ticks_ * setup_.period <= setup_.brake_time) return;
  axes_.set_goal(DriveGoal::Disabled);
  taking_torque_ = false;
}

/// Whatever is latched: it is not what the first fault is about. What has ended a homing may have asked for less.
void Loop::tell_not_braking(Fault fault, AxisId axis, double by, StationId station) noexcept {
  const auto um = static_cast<std::int32_t>(std::min(by * 1000, 2e9));
  if (latched_ == Fault::None || reacted_ < info(fault).reaction) return react(fault, axis, um, station);
  tell({.kind = EventKind::Fault, .fault = fault, .axis = axis, .station = station, .block = block_, .detail = um});
}

void Loop::follow_braking() noexcept {
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    const AxisId id{static_cast<std::uint8_t>(i)};
    if (const Axes::Unbraked& u = axes_.unbraked(id); u.fault != Fault::None)
      tell_not_braking(u.fault, id, u.by, u.station);
  }
}

/// The stop has taken as long as it may, and its torque goes from an axis that moves.
void Loop::tell_moving() noexcept {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d)
    if (axes_.moves(d))
      tell_not_braking(Fault::NotBraking, setup_.drives[d].axis, axes_.gone(d), setup_.drives[d].station);
}

/// A drive that keeps its torque though the stop is over is no consequence of the fault that stopped it.
void Loop::follow_kept_torque() noexcept {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    const devices::Feedback& f = axes_.drive(d);
    const DriveSetup& drive = setup_.drives[d];
    const bool kept =
        axes_.goal() == DriveGoal::Disabled && f.fresh && has_torque(f.state) && f.fault == Fault::TransitionTimeout;
    if (kept && !kept_torque_[d] && latched_ != Fault::None)
      tell({.kind = EventKind::Fault,
            .fault = f.fault,
            .axis = drive.axis,
            .station = drive.station,
            .block = block_,
            .detail = f.statusword});
    kept_torque_[d] = kept;
  }
}

/// Of axes that stand. One that still settles, behind frames that were lost or a fault that was reset, is braked first.
void Loop::give_up_torque() noexcept {
  if (at_rest()) return take_torque();
  if (axes_.goal() == DriveGoal::QuickStop) return;  // on its way to that already
  axes_.set_goal(DriveGoal::QuickStop);
  stop_ticks_ = 0;
}

/// At once where no brake is open, else when it holds.
void Loop::take_torque() noexcept {
  if (taking_torque_) return;
  if (!brake_released()) return axes_.set_goal(DriveGoal::Disabled);
  taking_torque_ = true;
  brake_ticks_ = 0;
}

/// While its axis has torque and is not about to lose it.
bool Loop::brake_released() const noexcept {
  const bool loses = taking_torque_ || axes_.goal() == DriveGoal::Disabled || axes_.goal() == DriveGoal::FaultReset;
  return setup_.brake_mask != 0 && !loses && axes_.has_torque(setup_.brake_axis);
}

/// Or the machine works none.
bool Loop::brake_open() const noexcept {
  return setup_.brake_mask == 0 || release_ticks_ * setup_.period > setup_.brake_release;
}

/// A probe that latches tells of it within cycles: a position that the axis has left longer ago is the latch of another
/// probe touch. That of one at the same height cannot be told apart.
bool Loop::latched_nearby() const noexcept {
  constexpr double kTold_s = 0.025, kAnyway = 0.05;  // mm or rad
  const std::size_t i = setup_.probe_axis.value;
  return std::abs(axes_.probe_position() - axes_.actual()[i]) <=
         kAnyway + kTold_s * std::abs(axes_.speed(setup_.probe_axis));
}

/// What standing still comes to.
Cause Loop::rest() const noexcept {
  if (latched_ != Fault::None) return Cause::RestLatched;
  return axes_.all_enabled() ? Cause::Rest : Cause::RestTorqueOff;
}

/// A latch goes when its cause has gone and the axes stand: the drives are asked first, and what this very cycle still
/// shows stays latched. Nothing is enabled and nothing moves; where a drive has lost its torque, the others lose
/// theirs, and the operator enables them together.
void Loop::finish_reset() noexcept {
  if (axes_.goal() == DriveGoal::QuickStop || taking_torque_) return;  // the stop first
  if (!at_rest() && ++settle_ticks_ * setup_.period < kStopTimeout) return;
  if (brake_released() && !(axes_.no_fault() && axes_.all_enabled())) return take_torque();
  if (!axes_.no_fault() && axes_.goal() != DriveGoal::FaultReset) axes_.set_goal(DriveGoal::FaultReset);
  if (!axes_.no_fault() && ++reset_ticks_ * setup_.period < kResetTimeout) return;
  // A drive that was told in this very cycle to give up its torque still shows it. Whoever hears that the machine is
  // without torque may enable it at once: it is said when it is so.
  const bool torque = axes_.all_enabled() && axes_.goal() == DriveGoal::Enabled;
  if (!torque && axes_.goal() != DriveGoal::FaultReset) axes_.set_goal(DriveGoal::Disabled);
  if (!torque && !axes_.all_disabled() && ++reset_ticks_ * setup_.period < kResetTimeout) return;
  if (axes_.no_fault()) {
    const bool another = present_.fault != Fault::None && present_.fault != latched_;  // behind the one that has gone
    latched_ = present_.fault;
    if (another) tell(present_);
  }
  if (latched_ == Fault::None) reacted_ = Reaction::Note;
  if (!torque) axes_.set_goal(DriveGoal::Disabled);
  if (latched_ == Fault::None) change(torque ? Cause::Cleared : Cause::ClearedTorqueOff);
  answer(std::exchange(pending_reset_, 0), latched_);
}

/// An axis that gives up ends the homing of the others: what is wrong with it may be wrong with them.
void Loop::watch_homing() noexcept {
  if (const Axes::Homed failed = axes_.homing_failure(); latches(info(failed.fault))) tell_homing(failed);
}

void Loop::tell_homing(const Axes::Homed& failed) noexcept {
  if (latched_ != Fault::None || failed.fault == Fault::None || failed.fault == Fault::Aborted) return;
  react(failed.fault, failed.axis, failed.detail, failed.station);
}

void Loop::finish_homing() noexcept {
  const Axes::Homed end = axes_.finish_homing();
  hold_position();
  tell_homing(end);
  for (std::size_t i = 0; i < setup_.axes.size(); ++i)
    if (const AxisId id{static_cast<std::uint8_t>(i)};
        (axes_.referenced() >> i & 1u) != 0 && axes_.apart_in_homing(id) > setup_.axes[i].skew_max)
      react(Fault::SidesApartInHoming, id, static_cast<std::int32_t>(axes_.apart_in_homing(id) * 1000));
  change(rest());
  answer_pending(end.fault != Fault::None ? end.fault : latched_);
}

void Loop::finish_block() noexcept {
  axes_.probe().stop();
  if (state_ == State::Running) {
    if (probing_)
      tell({.kind = EventKind::Fault, .fault = Fault::ProbeNeverTriggered, .axis = setup_.probe_axis, .block = block_});
    probing_ = false;
    tell({.kind = EventKind::BlockDone, .block = block_});
    change(Cause::BlockEnd);
  } else {
    tell({.kind = EventKind::BlockDone, .fault = std::exchange(stopped_by_, Fault::None), .block = block_});
    change(rest());
  }
  block_ = 0;
}

}  // namespace gantry::cycle
