#include "app/cycle/loop.hpp"

#include <algorithm>
#include <cmath>

#include "app/cycle/io_words.hpp"
#include "core/rt/trap.hpp"

namespace gantry::cycle {
namespace {

using devices::DriveGoal;

constexpr int kMostCommands = 8;  // a cycle; the rest waits
constexpr std::int64_t kMostSteps =
    200;  // of motion that a stalled cycle makes up for; beyond it the stall has stopped the machine anyway
constexpr int kResetTicks = 500;    // for the drives to leave their fault state
constexpr int kHealthyPeriod = 50;  // cycles: the "healthy" output is a pulse, so that a stuck output shows

AxisVec delays_of(const LoopSetup& setup) noexcept {
  AxisVec delays{};
  for (std::size_t i = 0; i < setup.axes.size(); ++i) delays[i] = setup.axes[i].response_delay_s;
  return delays;
}

}  // namespace

Loop::Loop(const LoopSetup& setup, devices::FieldBus& bus, devices::CanPort* can, Clock& clock, Channels& channels,
           StopFrame* stop)
    : setup_(setup),
      bus_(bus),
      can_(can),
      clock_(clock),
      channels_(channels),
      stop_(stop),
      axes_(setup_),
      supervisor_(setup_),
      interpolator_(channels.segments, setup_.limits, setup_.valve_mask),
      compensation_(setup_.limits, delays_of(setup_)) {}

Time Loop::tick(const Beat& beat) noexcept {
  const rt::Section in_loop;
  cycle_ = beat.cycle;
  heed_watchdog();
  take_commands();
  advance(beat);
  write_image(beat);

  const Time sending = clock_.now();
  exchange(beat, sending);
  const Time received = clock_.now();
  const devices::CanTick can = can_ != nullptr ? can_cyclic_.tick(*can_, received) : devices::CanTick{};
  if (can.fault != Fault::None) react(can.fault, kNoAxis, 0);

  axes_.read(bus_, exchange_.fault != Fault::FrameLost && exchange_.fault != Fault::BusDown, beat.elapsed);
  inputs_ = read_inputs(bus_, setup_, inputs_);
  const View view{beat, exchange_, axes_, commanded_.target, inputs_, state_, compute_};
  for (const Finding& found : supervisor_.look(view)) react(found.fault, found.axis, found.detail);
  follow_progress();

  bus_time_ = received - sending;
  compute_ = clock_.now() - beat.woke - bus_time_;
  tell_snapshot(beat, true);
  return dc_lock_.step(exchange_.dc_time_ns);
}

void Loop::exchange(const Beat& beat, Time now) noexcept {
  if (stop_ != nullptr) {
    stop_->make(bus_);
    stop_->begin_exchange(now);
    // Spoken for while this image was made: the old motion must not follow the stop. The next tick latches it.
    if (stop_->sent()) {
      stop_->write_into(bus_);
      sent_outputs_ = 0;
    }
  }
  exchange_ = bus_.exchange(beat.due + setup_.period * 2 / 5);
  if (stop_ != nullptr) stop_->end_exchange();
}

/// The watchdog has sent the stop frame while this loop stood still: the drives are stopping, and so is everything
/// here. Outputs that it has switched off stay off.
void Loop::heed_watchdog() noexcept {
  if (stop_ == nullptr || !stop_->take_sent()) return;
  const Time still = clock_.now() - stop_->last_beat();
  outputs_set_ = 0;
  react(Fault::WatchdogStop, kNoAxis, static_cast<std::int32_t>(still / milliseconds(1)));
}

// ---- commands ----

void Loop::take_commands() noexcept {
  if (channels_.stop_now.load(std::memory_order_acquire) &&
      (state_ == State::Running || state_ == State::Held || state_ == State::Homing))
    obey({.kind = CommandKind::Abort});
  Command command;
  for (int i = 0; i < kMostCommands && channels_.commands.pop(command); ++i) {
    if (const Fault why = refuse(command); why != Fault::None)
      answer(command.id, why);
    else
      obey(command);
  }
}

/// Why a command does not fit the machine's state; None when it does.
Fault Loop::refuse(const Command& command) const noexcept {
  const bool motion = command.kind == CommandKind::Enable || command.kind == CommandKind::Home ||
                      command.kind == CommandKind::ArmProbe || command.kind == CommandKind::StartBlock ||
                      command.kind == CommandKind::Resume;
  if (motion && latched_ != Fault::None) return Fault::Latched;
  switch (command.kind) {
    case CommandKind::Enable:
      if (state_ != State::Disabled) return Fault::Refused;
      if ((inputs_ & setup_.door_mask) != setup_.door_mask) return Fault::DoorOpen;
      return (inputs_ & setup_.air_mask) != setup_.air_mask ? Fault::AirMissing : Fault::None;
    case CommandKind::Home:
    case CommandKind::ArmProbe: return state_ == State::Ready ? Fault::None : Fault::Refused;
    case CommandKind::StartBlock:
      if (state_ != State::Ready) return Fault::Refused;
      return axes_.all_referenced() ? Fault::None : Fault::NotReferenced;
    case CommandKind::Disable:
      return state_ == State::Ready || state_ == State::Stopped || state_ == State::Disabled ? Fault::None
                                                                                             : Fault::Refused;
    case CommandKind::Hold: return state_ == State::Running ? Fault::None : Fault::Refused;
    case CommandKind::Resume: return state_ == State::Held ? Fault::None : Fault::Refused;
    case CommandKind::Abort:
    case CommandKind::Override:
    case CommandKind::SetOutputs: return Fault::None;
    case CommandKind::Reset: return state_ == State::Stopping ? Fault::Refused : Fault::None;
  }
  return Fault::Refused;
}

void Loop::obey(const Command& command) noexcept {
  switch (command.kind) {
    case CommandKind::Enable:
      axes_.set_goal(DriveGoal::Enabled);
      pending_ = command.id;
      enter(State::Enabling);
      return;
    case CommandKind::Disable:
      axes_.set_goal(DriveGoal::Disabled);
      outputs_set_ = 0;
      pending_disable_ = command.id;
      return;
    case CommandKind::Home:
      axes_.start_homing(command.axes);
      pending_ = command.id;
      enter(State::Homing);
      return;
    case CommandKind::ArmProbe:
      axes_.probe().start();
      pending_probe_ = command.id;
      return;
    case CommandKind::StartBlock:
      block_ = command.block;
      tick_ = 0;
      probing_ = false;
      interpolator_.begin_block(command.block);
      enter(State::Running);
      break;
    case CommandKind::Hold:
      interpolator_.hold();
      shut_valve_ = true;
      enter(State::Held);
      break;
    case CommandKind::Resume:
      interpolator_.resume();
      enter(State::Running);
      break;
    case CommandKind::Abort:
      if (state_ == State::Homing) axes_.cancel_homing(Fault::Aborted);
      if (state_ == State::Running || state_ == State::Held) {
        interpolator_.abort();
        shut_valve_ = true;
        stopped_by_ = Fault::Aborted;
        enter(State::Stopping);
      }
      break;
    case CommandKind::Override: override_ = std::clamp(command.value, 0.1, 2.0); break;
    case CommandKind::SetOutputs: {
      const std::uint32_t mask = command.mask & ~setup_.valve_mask;  // the valve opens with a dispense command only
      outputs_set_ = (outputs_set_ & ~mask) | (command.bits & mask);
      break;
    }
    case CommandKind::Reset:
      if (!axes_.no_fault()) axes_.set_goal(DriveGoal::FaultReset);
      pending_reset_ = command.id;
      reset_ticks_ = 0;
      return;
  }
  answer(command.id, Fault::None);
}

// ---- motion ----

/// Brings the commanded values to this cycle. Where the host stalled, the ticks in between are computed too, told as
/// not sent, and only the last one goes out: the target is that of the time, and the commanded stream has no holes.
void Loop::advance(const Beat& beat) noexcept {
  const AxisVec before = commanded_.target;
  const std::int64_t steps = std::min(beat.elapsed, kMostSteps);
  for (std::int64_t i = 1; i <= steps; ++i) {
    step_motion();
    if (i < steps) {
      Beat skipped = beat;
      skipped.cycle = beat.cycle - (steps - i);
      skipped.due = beat.due - (steps - i) * setup_.period;
      tell_snapshot(skipped, false);
    }
  }
  if (state_ == State::Offline || !axes_.all_enabled()) return;
  const motion::Verdict verdict =
      motion::check_target(setup_.limits, before, commanded_.target, static_cast<int>(steps - 1), axes_.referenced());
  if (verdict.fault != Fault::None) {
    react(verdict.fault, verdict.axis, 0);
    hold_position();
  }
}

void Loop::step_motion() noexcept {
  if (block_ != 0) ++tick_;
  commanded_.setpoint = interpolator_.step(override_);
  const motion::Compensated out = compensation_.step(commanded_.setpoint, shut_valve_ ? setup_.valve_mask : 0);
  shut_valve_ = false;  // it has cleared what was on its way; the interpolator keeps the valve shut from here on
  commanded_.target = out.q;
  commanded_.outputs = out.outputs;
  settled_ = out.settled;
  if (commanded_.setpoint.probing && !probe_told_) probing_ = true;  // while it brakes after the touch, it is over
}

void Loop::write_image(const Beat& beat) noexcept {
  std::uint32_t word = commanded_.outputs | outputs_set_;
  if (setup_.healthy_mask != 0 && latched_ == Fault::None && cycle_ / kHealthyPeriod % 2 == 0)
    word |= setup_.healthy_mask;
  sent_outputs_ = word;
  axes_.write(bus_, commanded_.target, beat.elapsed);
  write_outputs(bus_, setup_, word);
}

/// The interpolator stands where the drives are; nothing of the past is left in the compensation.
void Loop::hold_position() noexcept {
  const AxisVec here = axes_.commanded();
  interpolator_.start(here);
  compensation_.reset(here, commanded_.outputs & ~setup_.valve_mask);
  commanded_.target = here;
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
      interpolator_.probe_latched();
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

// ---- faults ----

void Loop::react(Fault fault, AxisId axis, std::int32_t detail) noexcept {
  const FaultInfo& row = info(fault);
  const bool first = latched_ == Fault::None;
  if (!latches(row)) {
    tell({.kind = EventKind::Fault, .fault = fault, .axis = axis, .block = block_, .detail = detail});
  } else if (first || row.reaction > info(latched_).reaction) {
    tell({.kind = EventKind::Fault, .fault = fault, .axis = axis, .block = block_, .detail = detail});
    if (first) latched_ = fault;
  } else {
    return;  // a consequence of what has already stopped the machine
  }
  if (row.clear == Clear::Rehome && axis != kNoAxis) axes_.forget_reference(axis);
  if (row.reaction == Reaction::Note) return;
  shut_valve_ = true;
  const bool moves = state_ == State::Running || state_ == State::Held || state_ == State::Stopping;
  if (row.reaction == Reaction::PathStop && moves) interpolator_.abort();
  if (row.reaction == Reaction::AxisStop && moves) interpolator_.axis_stop();
  if (state_ == State::Homing) axes_.cancel_homing(fault);
  if (row.reaction == Reaction::QuickStop) {
    if (moves) interpolator_.axis_stop();
    axes_.set_goal(DriveGoal::QuickStop);
  }
  if (row.reaction == Reaction::Off) axes_.set_goal(DriveGoal::Disabled);
  if (state_ == State::Enabling) {
    axes_.set_goal(DriveGoal::Disabled);
    answer_pending(fault);
  }
  if (moves && state_ != State::Stopping) stopped_by_ = fault;
  if (moves)
    enter(State::Stopping);
  else if (latches(row) && state_ != State::Homing && state_ != State::Offline)
    enter(State::Stopped);
}

// ---- telling ----

void Loop::enter(State state) noexcept {
  if (state == state_) return;
  state_ = state;
  tell({.kind = EventKind::StateChange, .block = block_, .detail = static_cast<std::int32_t>(state)});
}

void Loop::answer(std::uint32_t id, Fault fault) noexcept {
  if (id != 0) tell({.kind = EventKind::CommandDone, .fault = fault, .id = id, .block = block_});
}

void Loop::answer_pending(Fault fault) noexcept {
  answer(pending_, fault);
  pending_ = 0;
}

void Loop::tell(Event event) noexcept {
  event.cycle = cycle_;
  if (!channels_.events.push(event)) channels_.lost.fetch_add(1, std::memory_order_relaxed);
}

void Loop::tell_snapshot(const Beat& beat, bool sent) noexcept {
  Snapshot& s = snapshot_;
  s.cycle = beat.cycle;
  s.time_ns = beat.due.count();
  s.wake_ns = static_cast<std::int32_t>(std::min<std::int64_t>((beat.woke - beat.due).count(), INT32_MAX));
  s.compute_ns = static_cast<std::int32_t>(compute_.count());
  s.bus_ns = static_cast<std::int32_t>(bus_time_.count());
  s.dc_error_ns = static_cast<std::int32_t>(dc_lock_.error().count());
  s.state = state_;
  s.sent = sent;
  s.inputs_fresh = exchange_.inputs_fresh;
  s.latched = latched_;
  s.block = block_;
  s.tick = tick_;
  s.feature = commanded_.setpoint.feature;
  s.outputs = sent ? sent_outputs_ : commanded_.outputs | outputs_set_;
  s.inputs = inputs_;
  s.working_counter = exchange_.working_counter;
  s.expected = exchange_.expected;
  s.al_states = exchange_.al_states;
  s.axes = static_cast<std::uint8_t>(setup_.axes.size());
  s.drives = static_cast<std::uint8_t>(setup_.drives.size());
  s.enabled = axes_.enabled_mask();
  s.referenced = axes_.referenced();
  s.override_factor = override_;
  s.path_speed = commanded_.setpoint.s_dot;
  s.target = commanded_.target;
  s.actual = axes_.actual();
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    const AxisId id{static_cast<std::uint8_t>(i)};
    s.following[i] = axes_.measures_following(id) ? axes_.following(id, commanded_.target[i]) : std::nan("");
  }
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    s.counts[d] = sent ? axes_.sent_counts(d) : axes_.counts_of(d, commanded_.target);
    s.statusword[d] = axes_.drive(d).statusword;
    s.error_code[d] = axes_.drive(d).error_code;
  }
  if (!channels_.snapshots.push(s)) channels_.lost.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace gantry::cycle
