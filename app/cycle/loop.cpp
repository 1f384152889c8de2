#include "app/cycle/loop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/cycle/interlocks.hpp"
#include "app/cycle/io_words.hpp"
#include "core/rt/trap.hpp"

namespace gantry::cycle {
namespace {

using devices::DriveGoal;

constexpr std::int64_t kMostSteps =
    200;  // of motion that a stalled cycle makes up for; beyond it the stall has stopped the machine anyway
constexpr Time kHealthyHalf = milliseconds(50);  // the "healthy" output is a pulse, so that a stuck output shows

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
      compensation_(setup_.limits, delays_of(setup_)),
      dc_lock_(devices::dc_lock_options(setup_.period)) {}

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

  axes_.read(bus_, answered(), exchange_.operational, beat.elapsed);
  inputs_ = read_inputs(bus_, setup_, inputs_);
  const View view{beat, exchange_, axes_, commanded_.target, inputs_, state_, compute_, purpose_};
  present_ = {};
  for (const Finding& found : supervisor_.look(view))
    react(found.fault, found.axis, found.detail, found.station, found.value);
  heed_silence();
  follow_progress();

  bus_time_ = received - sending;
  compute_ = clock_.now() - beat.woke - bus_time_;
  tell_snapshot(beat, true);
  const Time shift = dc_lock_.step(exchange_.reference_ns);
  bus_.arm(frame_deadline(beat.due + setup_.period + shift));
  return shift;
}

/// A frame that is not back two fifths into its cycle counts as lost: SYNC0 comes half a cycle after it was due.
Time Loop::frame_deadline(Time due) const noexcept { return due + setup_.period * 2 / 5; }

/// Drives that the stop frame lets stand with torque: those that only their targets brake, while anything moves. When
/// all stand, none needs it any more but an axis whose brake closes only now.
std::uint32_t Loop::held_by_last_word() const noexcept {
  const std::uint32_t braked = axes_.braked_by_targets();
  if (!at_rest()) return braked;
  std::uint32_t held = 0;
  if (brake_released())
    for (const std::uint8_t d : setup_.axes[setup_.brake_axis.value].drives) held |= 1u << d;
  return braked & held;
}

void Loop::exchange(const Beat& beat, Time now) noexcept {
  if (stop_ != nullptr) {
    stop_->make(bus_, held_by_last_word());
    stop_->begin_exchange(now);
    // Spoken for while this image was made: the old motion must not follow the stop. The next tick latches it.
    if (stop_->sent()) {
      stop_->write_into(bus_);
      sent_outputs_ &= setup_.held_mask;
    }
  }
  exchange_ = bus_.exchange(frame_deadline(beat.due));
  if (stop_ != nullptr) stop_->end_exchange();
}

/// The watchdog has sent the stop frame while this loop stood still: the drives are stopping, and so is everything
/// here. Outputs that it has switched off stay off.
void Loop::heed_watchdog() noexcept {
  if (stop_ == nullptr || !stop_->take_sent()) return;
  const Time still = clock_.now() - stop_->last_beat();
  outputs_set_ &= setup_.held_mask;
  react(Fault::WatchdogStop, kNoAxis, static_cast<std::int32_t>(still / milliseconds(1)));
  if (axes_.goal() == DriveGoal::QuickStop) axes_.stand_only(stop_->standing());
  hold_position();  // drives that do not brake by themselves stand at their last targets
}

/// Frames that do not come back may not have come to the drives either: these stand at the last target that did. A
/// target that went on to brake would be far ahead of them when the first frame comes through, and they would leap
/// after it. So it stands, too, no farther ahead than the frames that may be lost; it has been reacted to.
void Loop::heed_silence() noexcept {
  silent_ = answered() ? 0 : std::min(silent_ + 1, setup_.frames_lost_max);
  if (silent_ == setup_.frames_lost_max) hold_position();
}

// ---- motion ----

/// Brings the commanded values to this cycle. Where the host stalled, the ticks in between are computed too, told as
/// not sent, and only the last one goes out: the target is that of the time, and the commanded stream has no holes.
void Loop::advance(const Beat& beat) noexcept {
  const AxisVec before_last = before_last_, last = commanded_.target;
  const std::int64_t steps = std::min(beat.elapsed, kMostSteps);
  for (std::int64_t i = 1; i <= steps; ++i) {
    before_last_ = commanded_.target;
    step_motion();
    if (i < steps) {
      Beat skipped = beat;
      skipped.cycle = beat.cycle - (steps - i);
      skipped.due = beat.due - (steps - i) * setup_.period;
      tell_snapshot(skipped, false);
    }
  }
  if (state_ == State::Offline || !axes_.all_enabled()) return;
  const bool walks = block_ != 0 && purpose_ == Purpose::Walk;
  const motion::Verdict verdict =
      motion::check_target(walks ? walk_limits_ : setup_.limits, before_last, last, commanded_.target,
                           static_cast<int>(steps - 1), walks ? ~0u : axes_.referenced());
  if (verdict.fault == Fault::None) return;
  react(verdict.fault, verdict.axis, 0);
  if (verdict.fault == Fault::SoftLimit)
    hold_position();
  else
    brake_from(before_last, last);
}

/// What came to here was good, what would have followed is not: every axis brakes from these two targets, a tick apart.
void Loop::brake_from(const AxisVec& before_last, const AxisVec& last) noexcept {
  AxisVec v{};
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) v[i] = (last[i] - before_last[i]) / setup_.limits.tick_s;
  interpolator_.axis_stop_from(compensation_.go_on(last, v, commanded_.outputs & ~setup_.valve_mask), v);
  before_last_ = last;
  step_setpoint();
}

void Loop::step_motion() noexcept {
  if (hold_waits_ && compensation_.clear_of(setup_.valve_mask) && !interpolator_.lays_its_last()) hold();
  valve_cut_ = shut_valve_ && (sent_outputs_ & setup_.valve_mask) != 0;
  if (block_ != 0) ++tick_;
  step_setpoint();
  const bool starves = block_ != 0 && interpolator_.starving();
  if (starves && !starves_) react(Fault::Starved, kNoAxis, 0);
  starves_ = starves;
  if (commanded_.setpoint.off_path) react(Fault::TargetStep, kNoAxis, 0);
  if (commanded_.setpoint.probing && !probe_over_) watch_approach();  // while it brakes after the touch, it is over
}

void Loop::step_setpoint() noexcept {
  commanded_.setpoint = interpolator_.step(keeps_planned_speed(purpose_) ? std::min(override_, 1.0) : override_);
  const motion::Compensated out = compensation_.step(commanded_.setpoint, shut_valve_ ? setup_.valve_mask : 0);
  shut_valve_ = false;  // it has cleared what was on its way; the interpolator keeps the valve shut from here on
  commanded_.target = out.q;
  commanded_.outputs = out.outputs;
  settled_ = out.settled;
}

/// What the motion, orders and the machine's state come to in this cycle.
std::uint32_t Loop::output_word(CycleIndex cycle) const noexcept {
  std::uint32_t word = commanded_.outputs | outputs_set_;
  if (setup_.healthy_mask != 0 && latched_ == Fault::None && cycle * setup_.period / kHealthyHalf % 2 == 0)
    word |= setup_.healthy_mask;
  word |= setup_.lamp_masks[static_cast<std::size_t>(lamp())];
  return brake_released() ? word | setup_.brake_mask : word;
}

void Loop::write_image(const Beat& beat) noexcept {
  const std::uint32_t word = output_word(cycle_);
  const bool released = brake_released();
  if (!released || !brake_open()) release_ticks_ = released ? release_ticks_ + 1 : 0;
  sent_outputs_ = word;
  axes_.write(bus_, commanded_.target, beat.elapsed);
  write_outputs(bus_, setup_, word);
}

/// Of the stack light: red while a fault is latched, yellow in setup and where a job waits for somebody to resume it.
Lamp Loop::lamp() const noexcept {
  if (latched_ != Fault::None) return Lamp::Red;
  const Lamp lamp = row(state_).lamp;
  const bool waits = state_ == State::Ready && channels_.on_hold.load(std::memory_order_relaxed);
  return in_setup(setup_, inputs_) || waits ? Lamp::Yellow : lamp;
}

/// The interpolator stands where the drives are; nothing of the past is left in the compensation.
void Loop::hold_position() noexcept {
  const AxisVec here = axes_.commanded();
  interpolator_.start(here);
  compensation_.reset(here, commanded_.outputs & ~setup_.valve_mask);
  commanded_.target = before_last_ = here;
}

// ---- faults ----

void Loop::react(Fault fault, AxisId axis, std::int32_t detail, StationId station, double value) noexcept {
  const FaultInfo& info_row = info(fault);
  if (info_row.clear == Clear::Rehome && axis != kNoAxis) axes_.forget_reference(axis);  // whatever else is wrong
  const bool latching = latches(info_row);
  const Event event{.kind = EventKind::Fault,
                    .fault = fault,
                    .axis = axis,
                    .station = station,
                    .block = block_,
                    .detail = detail,
                    .value = value};
  if (latching && (present_.fault == Fault::None || info_row.reaction > info(present_.fault).reaction))
    present_ = event;
  const bool first = latched_ == Fault::None;
  // What calls for no more than what was done already is a consequence of it, or the same again.
  const bool cause = explains(fault);
  const bool ends = !first && outlived(info(latched_)) && !outlived(info_row);  // a job that would have gone on
  if (latching && !first && info_row.reaction <= reacted_ && !cause && !ends) return;
  tell(event);
  if (fault == Fault::TransitionTimeout)
    for (std::size_t d = 0; d < setup_.drives.size(); ++d)
      if (setup_.drives[d].axis == axis && setup_.drives[d].station == station) kept_torque_[d] = true;
  if (latching) {
    if (first || cause || ends) latched_ = fault;
    if (first) latched_at_ = cycle_;
    reacted_ = std::max(reacted_, info_row.reaction);
  }
  if (const ReactionRow* reaction = row(info_row.reaction)) carry_out(*reaction, fault);
}

/// An emergency stop takes the drives' supply: the bus may miss them before the input of the safety chain has come.
bool Loop::explains(Fault fault) const noexcept {
  constexpr Time kDecay = milliseconds(200);
  constexpr int kBusAndDrives = 300;  // the catalogue numbers these below
  return fault == Fault::SafetyChainOpen && latched_ != Fault::None && static_cast<int>(latched_) < kBusAndDrives &&
         (cycle_ - latched_at_) * setup_.period <= kDecay;
}

void Loop::carry_out(const ReactionRow& reaction, Fault fault) noexcept {
  shut_valve_ = true;
  hold_waits_ = false;
  const bool on_path = block_ != 0;
  if (reaction.braking == Braking::OnPath && on_path) interpolator_.abort();
  if (reaction.braking == Braking::EachAxis && on_path) interpolator_.axis_stop();
  if (state_ == State::Homing) axes_.cancel_homing(fault);
  if (reaction.goal) axes_.set_goal(*reaction.goal), stop_ticks_ = 0;
  if (state_ == State::Enabling || state_ == State::Disabling) {
    if (!reaction.goal) give_up_torque();
    answer_pending(fault);
    answer(std::exchange(pending_disable_, 0), fault);  // the torque goes all the same
  }
  if (!on_path && latched_ != Fault::None) disarm(fault);
  if (on_path && state_ != State::Stopping) stopped_by_ = fault;
  if (on_path || latched_ != Fault::None) change(reaction.cause);
}

// ---- telling ----

void Loop::change(Cause cause) noexcept {
  const std::optional<State> to = next(state_, cause);
  if (!to || *to == state_) return;
  state_ = *to;
  tell({.kind = EventKind::StateChange, .block = block_, .detail = static_cast<std::int32_t>(state_)});
}

void Loop::answer(std::uint32_t id, Fault fault, AxisId axis) noexcept {
  if (id != 0) tell({.kind = EventKind::CommandDone, .fault = fault, .axis = axis, .id = id, .block = block_});
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
  s.wake_ns = static_cast<std::int32_t>(
      std::min<std::int64_t>((beat.woke - beat.due + beat.still * setup_.period).count(), INT32_MAX));
  s.compute_ns = static_cast<std::int32_t>(compute_.count());
  s.bus_ns = static_cast<std::int32_t>(bus_time_.count());
  s.in_time = dc_lock_.locked() || (exchange_.inputs_fresh && exchange_.reference_ns == 0);
  s.state = state_;
  s.sent = sent;
  s.answered = answered();
  s.inputs_fresh = exchange_.inputs_fresh;
  s.latched = latched_;
  s.block = block_;
  s.tick = tick_;
  s.feature = commanded_.setpoint.feature;
  s.valve_cut = valve_cut_;
  s.outputs = sent ? sent_outputs_ : output_word(beat.cycle);
  s.inputs = inputs_;
  s.complete = exchange_.complete;
  s.operational = exchange_.operational;
  s.working_counter = exchange_.ethercat.working_counter;
  s.expected = exchange_.ethercat.expected;
  s.al_states = exchange_.ethercat.al_states;
  s.axes = static_cast<std::uint8_t>(setup_.axes.size());
  s.drives = static_cast<std::uint8_t>(setup_.drives.size());
  s.enabled = axes_.enabled_mask();
  s.referenced = axes_.referenced();
  s.override_factor = override_;
  s.path_speed = commanded_.setpoint.s_dot;
  s.along_block_mm = commanded_.setpoint.along_block_mm;
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
