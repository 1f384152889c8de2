// What the run thread asks of the loop: refused with a reason, or carried out.
#include <algorithm>

#include "app/cycle/interlocks.hpp"
#include "app/cycle/loop.hpp"

namespace gantry::cycle {

using devices::DriveGoal;

namespace {
constexpr int kMostCommands = 8;  // a cycle; the rest waits
}

std::optional<Cause> cause(CommandKind kind) noexcept {
  switch (kind) {
    case CommandKind::Enable: return Cause::Enable;
    case CommandKind::Disable: return Cause::Disable;
    case CommandKind::Home: return Cause::Home;
    case CommandKind::ArmProbe:
    case CommandKind::StartBlock: return Cause::Play;
    case CommandKind::Hold: return Cause::Hold;
    case CommandKind::Resume: return Cause::Resume;
    case CommandKind::Abort: return Cause::Abort;
    case CommandKind::Reset: return Cause::Reset;
    case CommandKind::Override:
    case CommandKind::SetOutputs: break;
  }
  return std::nullopt;
}

void Loop::take_commands() noexcept {
  aborting_ = channels_.stop_now.load(std::memory_order_acquire);
  if (aborting_ && (row(state_).moves || state_ == State::Held || state_ == State::Enabling))
    obey({.kind = CommandKind::Abort});
  Command command;
  for (int i = 0; i < kMostCommands && channels_.commands.pop(command); ++i) {
    if (const Fault why = refuse(command); why != Fault::None) {
      if (command.kind == CommandKind::StartBlock) interpolator_.forget(command.block);
      const AxisId axis = why == Fault::LimitSwitch ? axes_.first_on_limit() : kNoAxis;
      if (command.id != 0)
        tell({.kind = EventKind::CommandDone, .fault = why, .axis = axis, .id = command.id, .block = block_});
    } else {
      obey(command);
    }
  }
}

/// Why a command does not fit the machine's state; None when it does.
Fault Loop::refuse(const Command& command) const noexcept {
  const std::optional<Cause> order = cause(command.kind);
  if (!order) return Fault::None;
  const bool to_motion =
      order == Cause::Enable || order == Cause::Home || order == Cause::Play || order == Cause::Resume;
  if (to_motion && aborting_) return Fault::Aborted;
  if (to_motion && latched_ != Fault::None) return Fault::Latched;
  if (!next(state_, *order)) return Fault::Refused;
  // Both set what the drives are asked for.
  if (command.kind == CommandKind::Enable) return pending_reset_ != 0 ? Fault::Refused : interlock();
  const bool in_setup = cycle::in_setup(setup_, inputs_);
  const bool start = command.kind == CommandKind::StartBlock;
  if (start && command.purpose == Purpose::Walk) return refuse_walk(in_setup);
  if (in_setup && (command.kind == CommandKind::Home || (start && !plays_in_setup(command.purpose))))
    return Fault::SetupMode;
  if (start && !axes_.all_referenced()) return Fault::NotReferenced;
  if (command.kind == CommandKind::Reset && pending_reset_ != 0) return Fault::Refused;
  return Fault::None;
}

/// It is not known where the axes stand: one that stands on a limit switch may be anywhere behind it.
Fault Loop::refuse_walk(bool in_setup) const noexcept {
  if (setup_.mode_mask != 0 && !in_setup) return Fault::Refused;
  return axes_.first_on_limit() != kNoAxis ? Fault::LimitSwitch : Fault::None;
}

/// Whatever was planned, no axis goes farther than this.
void Loop::bound_walk() noexcept {
  walk_limits_ = setup_.limits;
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    walk_limits_.axis[i].p_min = commanded_.target[i] - setup_.walk_max[i];
    walk_limits_.axis[i].p_max = commanded_.target[i] + setup_.walk_max[i];
  }
}

/// What keeps the drives from having torque, by the inputs; None when nothing does. In setup the door may be open.
Fault Loop::interlock() const noexcept {
  for (const Interlock& lock : kInterlocks)
    if (is_open(lock, setup_, inputs_)) return lock.open;
  return Fault::None;
}

void Loop::obey(const Command& command) noexcept {
  if (const auto order = cause(command.kind); order && command.kind != CommandKind::ArmProbe) change(*order);
  switch (command.kind) {
    case CommandKind::Enable:
      taking_torque_ = false;
      axes_.set_goal(DriveGoal::Enabled);
      pending_ = command.id;
      return;
    case CommandKind::Disable:
      answer_pending(Fault::Aborted);  // an Enable that this overtakes
      give_up_torque();
      pending_disable_ = command.id;
      return;
    case CommandKind::Home:
      axes_.start_homing(command.axes, bus_);
      pending_ = command.id;
      return;
    case CommandKind::ArmProbe:
      axes_.probe().start(devices::ProbeEdge::Rising, setup_.period);
      pending_probe_ = command.id;
      return;
    case CommandKind::StartBlock:
      block_ = command.block;
      hold_waits_ = false;
      purpose_ = command.purpose;
      if (purpose_ == Purpose::Walk) bound_walk();
      tick_ = 0;
      probing_ = probe_over_ = false;
      interpolator_.begin_block(command.block);
      break;
    case CommandKind::Hold:
      // What a hold would cut short comes to its end first, whoever asks.
      if (!interpolator_.lays_its_last() &&
          (command.value >= 1 || hold_waits_ || (sent_outputs_ & setup_.valve_mask) == 0))
        hold();
      else
        hold_waits_ = true;
      break;
    case CommandKind::Resume:
      hold_waits_ = false;
      interpolator_.resume();
      break;
    case CommandKind::Abort: abort(); break;
    case CommandKind::Override:
      override_ = std::clamp(command.value, motion::kLeastOverride, motion::kMostOverride);
      break;
    case CommandKind::SetOutputs: {
      // The valve opens with a dispense command only, the brake when its axis has torque.
      const std::uint32_t mask = command.mask & ~(setup_.valve_mask | setup_.brake_mask);
      outputs_set_ = (outputs_set_ & ~mask) | (command.bits & mask);
      break;
    }
    case CommandKind::Reset:
      pending_reset_ = command.id;
      reset_ticks_ = settle_ticks_ = 0;
      return;
  }
  answer(command.id, Fault::None);
}

void Loop::hold() noexcept {
  hold_waits_ = false;
  interpolator_.hold();
  shut_valve_ = true;
}

/// The state has changed already: what was under way ends.
void Loop::abort() noexcept {
  if (block_ == 0) disarm(Fault::Aborted);
  if (state_ == State::Homing) axes_.cancel_homing(Fault::Aborted);
  if (state_ == State::Disabling && pending_ != 0) {  // it was enabling
    give_up_torque();
    answer_pending(Fault::Aborted);
  }
  if (state_ != State::Stopping || stopped_by_ != Fault::None) return;
  interpolator_.abort();
  hold_waits_ = false;
  shut_valve_ = true;
  stopped_by_ = Fault::Aborted;
}

}  // namespace gantry::cycle
