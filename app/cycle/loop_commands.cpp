// What the run thread asks of the loop: refused with a reason, or carried out.
#include "app/cycle/loop.hpp"

namespace gantry::cycle {

using devices::DriveGoal;

namespace {
constexpr int kMostCommands = 8;  // a cycle; the rest waits
}

void Loop::take_commands() noexcept {
  if (channels_.stop_now.load(std::memory_order_acquire) &&
      (state_ == State::Running || state_ == State::Held || state_ == State::Homing))
    obey({.kind = CommandKind::Abort});
  Command command;
  for (int i = 0; i < kMostCommands && channels_.commands.pop(command); ++i) {
    if (const Fault why = refuse(command); why != Fault::None) {
      if (command.kind == CommandKind::StartBlock) interpolator_.forget(command.block);
      answer(command.id, why);
    } else {
      obey(command);
    }
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
      clamp_may_be_open_ = command.clamp_may_be_open;
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

}  // namespace gantry::cycle
