// What takes several cycles: probing, enabling, resetting, homing, blocks. Looked at in every cycle, answered when
// over.
#include "app/cycle/loop.hpp"

namespace gantry::cycle {

using devices::DriveGoal;

namespace {
constexpr int kResetTicks = 500;  // for the drives to leave their fault state
}

/// Everything that takes several cycles and is now over.
void Loop::follow_progress() noexcept {
  using Probe = devices::ProbeArm::Phase;
  const Probe probe = axes_.probe().phase();
  if (pending_probe_ != 0 && (probe == Probe::Armed || probe == Probe::Failed)) {
    answer(pending_probe_, probe == Probe::Armed ? Fault::None : axes_.probe().fault());
    pending_probe_ = 0;
  }
  if (probe == Probe::Latched && !probe_told_) {
    probe_told_ = true;
    if (probing_) {
      probing_ = false;
      interpolator_.probe_latched(setup_.probe_axis, axes_.probe_position());
      tell({.kind = EventKind::Touched, .axis = setup_.probe_axis, .block = block_, .value = axes_.probe_position()});
    } else {
      react(Fault::ProbeImplausible, setup_.probe_axis, 0);
    }
  }
  if (probe != Probe::Latched) probe_told_ = false;

  switch (state_) {
    case State::Offline:
      if (exchange_.fault == Fault::None && exchange_.al_states == 8) enter(State::Disabled);
      hold_position();
      break;
    case State::Disabled:
    case State::Stopped:
      if (!axes_.all_enabled()) hold_position();
      break;
    case State::Enabling:
      hold_position();
      if (axes_.all_enabled()) enter(State::Ready), answer_pending(Fault::None);
      break;
    case State::Homing:
      if (axes_.homing()) break;
      finish_homing();
      break;
    case State::Running:
    case State::Stopping: finish_block(); break;
    case State::Ready:
    case State::Held: break;
  }
  if (pending_reset_ != 0) finish_reset();
  if (pending_disable_ != 0 && axes_.all_disabled()) {
    answer(pending_disable_, Fault::None);
    pending_disable_ = 0;
    if (state_ == State::Ready) enter(State::Disabled);
  }
}

/// A latch goes when its cause has gone: the drives are asked first. Nothing is enabled and nothing moves; where a
/// drive has lost its torque, the others lose theirs, and the operator enables them together.
void Loop::finish_reset() noexcept {
  if (!axes_.no_fault() && ++reset_ticks_ < kResetTicks) return;
  const bool cleared = axes_.no_fault();
  if (cleared) latched_ = Fault::None;
  if (!axes_.all_enabled()) axes_.set_goal(DriveGoal::Disabled);
  if (cleared && state_ == State::Stopped) enter(axes_.all_enabled() ? State::Ready : State::Disabled);
  answer(pending_reset_, latched_);
  pending_reset_ = 0;
}

void Loop::finish_homing() noexcept {
  AxisId axis = kNoAxis;
  const Fault failed = axes_.finish_homing(axis);
  hold_position();
  if (latched_ != Fault::None) {
    enter(State::Stopped);
  } else if (failed != Fault::None && failed != Fault::Aborted) {
    react(failed, axis, 0);
    enter(State::Stopped);
  } else {
    enter(axes_.all_enabled() ? State::Ready : State::Disabled);
  }
  answer_pending(failed != Fault::None ? failed : latched_);
}

void Loop::finish_block() noexcept {
  if (!interpolator_.idle() || !interpolator_.at_rest() || !settled_) return;
  axes_.probe().stop();
  if (state_ == State::Running) {
    if (probing_)
      tell({.kind = EventKind::Fault, .fault = Fault::ProbeNeverTriggered, .axis = setup_.probe_axis, .block = block_});
    probing_ = false;
    tell({.kind = EventKind::BlockDone, .block = block_});
    enter(State::Ready);
  } else {
    tell({.kind = EventKind::BlockDone, .fault = stopped_by_, .block = block_});
    enter(latched_ != Fault::None ? State::Stopped : axes_.all_enabled() ? State::Ready : State::Disabled);
  }
  block_ = 0;
}

}  // namespace gantry::cycle
