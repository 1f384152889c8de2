#include "sim/drive/drive402.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "sim/random.hpp"
#include "sim/whole.hpp"

namespace gantry::sim {

using namespace devices::wire;
using namespace devices::wire::cia402;
using config::DriveErrorKind;

namespace {

constexpr std::uint16_t kPositionDemand = 0x6062;
constexpr std::uint16_t kNoError = 0x0000;  // emergency: the error is gone (CiA 301, 7.2.7)
constexpr int kNoQuickStopOption = 0;  // where the drive has no 605Ah: the torque goes (assumed, the worst of them)
constexpr double kOwnHomingAcceleration_counts_s2 = 1e6;  // where the drive has no 609Ah (assumed)
constexpr double kDeviationRevolutions = 1;  // AMD530B 2030h: 1 revolution; the others state encoder counts (assumed)

/// What the controlword asks for (IEC 61800-7-201, command coding).
enum class Command { DisableVoltage, QuickStop, Shutdown, SwitchOn, EnableOperation };
Command decode(std::uint16_t cw) noexcept {
  if ((cw & kEnableVoltage) == 0) return Command::DisableVoltage;
  if ((cw & kNoQuickStop) == 0) return Command::QuickStop;
  if ((cw & kSwitchOn) == 0) return Command::Shutdown;
  return (cw & kEnableOperation) != 0 ? Command::EnableOperation : Command::SwitchOn;
}

/// The row of a mode; without one the plain CiA 402 values, with bit 12 where the standard sets it.
config::StatuswordRow row_of(const config::DriveFacts& facts, std::int8_t mode) {
  for (const auto& row : facts.statuswords)
    if (row.mode == mode) return row;
  config::StatuswordRow row;
  row.mode = mode;
  if (mode == kCsp) row.enabled = row.running = row.reached = 0x0237 | kFollowsCommand;
  return row;
}

const config::DriveErrorRow* error_row(const config::DriveFacts& facts, std::uint32_t code) noexcept {
  const auto at = std::find_if(facts.errors.begin(), facts.errors.end(), [&](const auto& e) { return e.code == code; });
  return at != facts.errors.end() ? &*at : nullptr;
}

/// 603Fh of a limit switch: of the profile's limit rows the first is the positive one, the second the negative one.
std::uint16_t limit_code(const config::DriveFacts& facts, bool positive) noexcept {
  int skip = positive ? 0 : 1;
  for (const auto& row : facts.errors)
    if (row.kind == DriveErrorKind::Limit && skip-- == 0) return static_cast<std::uint16_t>(row.code);
  return 0;
}

}  // namespace

Drive402::Drive402(ObjectDictionary& objects, int slot, Motor& motor, double counts_per_unit, bool invert)
    : facts_(*objects.profile().drive),
      motor_(&motor),
      motion_(motor, counts_per_unit, invert, facts_.closed_loop),
      probe_(facts_.probe_rearm_needs_zero, facts_.probe_level_bit),
      objects_(objects),
      slot_(slot),
      controlword_(object(kControlword)),
      status_(object(kStatusword)),
      mode_wanted_(object(kMode)),
      mode_shown_(object(kModeDisplay)),
      actual_(object(kActualPosition)),
      velocity_(object(kActualVelocity)),
      demand_(object(kPositionDemand)),
      target_(object(kTargetPosition)),
      error_(object(kErrorCode)),
      probe_function_(object(kProbeFunction)),
      probe_status_(object(kProbeStatus)),
      probe_rising_(object(kProbe1Rising)),
      probe_falling_(object(kProbe1Falling)),
      inputs_(object(kDigitalInputs)),
      home_offset_(object(kHomeOffset)),
      homing_method_(object(kHomingMethod)),
      homing_fast_(object(kHomingSpeeds, 1)),
      homing_slow_(object(kHomingSpeeds, 2)),
      homing_acceleration_(object(kHomingAcceleration)),
      quick_option_(object(kQuickStopOption)),
      deceleration_(object(kProfileDeceleration)),
      quick_deceleration_(object(kQuickStopDeceleration)),
      inputs_base_(static_cast<std::uint32_t>(inputs_.value)) {
  if (objects_.find(quick_option_.address) == nullptr) quick_option_.value = kNoQuickStopOption;
  if (objects_.find(homing_acceleration_.address) == nullptr)
    homing_acceleration_.value = std::llround(kOwnHomingAcceleration_counts_s2 / facts_.acceleration_counts_s2);
  for (const config::Parameter& p : objects_.profile().parameters)
    if (p.name == facts_.probe_input.parameter)
      probe_input_ = objects_.find(config::in_slot(objects_.profile(), p.address, slot_));
  levels_ = motion_.inputs();
  take_mode();
  sample();
}

Object& Drive402::object(std::uint16_t index, std::uint8_t sub) {
  const auto on_slot = static_cast<std::uint16_t>(index + slot_ * objects_.profile().slot_stride);
  if (Object* found = objects_.find({on_slot, sub})) return *found;
  return absent_.at(absent_used_++);
}

void Drive402::tell(const DriveLies& lies) noexcept {
  lies_ = lies;
  if (lies_.counter_begin != 0) motion_.set_counts(lies_.counter_begin);
}

bool Drive402::input_is_probes() const noexcept {
  return probe_input_ == nullptr || probe_input_->value == facts_.probe_input.value;
}

bool Drive402::faulted() const noexcept { return state_ == State::Fault || state_ == State::FaultReaction; }

std::uint32_t Drive402::visible(std::uint32_t inputs) const noexcept {
  std::uint32_t mask = kProbe;
  if (facts_.input_neg_limit >= 0) mask |= kNegLimit;
  if (facts_.input_pos_limit >= 0) mask |= kPosLimit;
  if (facts_.input_home >= 0) mask |= kHome;
  return inputs & mask;
}

// --- Motion up to this instant
// -----------------------------------------------------------------------------------------

void Drive402::advance(double dt_s) noexcept {
  if (state_ != State::OperationEnabled && state_ != State::QuickStopActive && state_ != State::FaultReaction)
    motion_.slip(dt_s);
  double left = dt_s;
  for (int edges = 0; left > 0 && edges < 64; ++edges) {
    std::uint32_t watch = kNegLimit | kPosLimit;
    if (homing_ == HomingState::Running) watch |= kHome;
    if (probe_.armed()) watch |= kProbe;
    const std::uint32_t changed = motion_.advance(left, visible(watch));
    if (changed != 0) on_inputs(changed, visible(motion_.inputs()));
  }
  if (!motion_.commands_motion()) finish_stop();
  if (state_ == State::OperationEnabled && facts_.closed_loop &&
      std::abs(motion_.deviation()) > kDeviationRevolutions * facts_.counts_per_rev)
    fault(facts_.deviation_code);
}

void Drive402::on_inputs(std::uint32_t changed, std::uint32_t levels) noexcept {
  levels_ = levels;
  if ((changed & kProbe) != 0 && input_is_probes()) probe_.on_edge((levels & kProbe) != 0, motion_.counts());
  if (homing_ == HomingState::Running) return on_homing_input(changed, levels);
  for (const auto& [input, direction] : {std::pair{kPosLimit, +1}, std::pair{kNegLimit, -1}}) {
    if ((changed & input) == 0) continue;
    if ((levels & input) != 0)
      motion_.block(direction);
    else
      motion_.release(direction);
  }
}

void Drive402::finish_stop() noexcept {
  switch (after_stop_) {
    case AfterStop::Nothing: break;
    case AfterStop::Disable:
      if (std::abs(motion_.deviation()) >= 1 && std::abs(motion_.speed()) >= 1) return;  // the motor comes after it
      disable();
      break;
    case AfterStop::Fault: state_ = State::Fault; break;
  }
  after_stop_ = AfterStop::Nothing;
  // Done and standing: the switches of the limits hold again, and bits 10 and 12 may show.
  if (homing_ == HomingState::Stopping && std::abs(motion_.deviation()) < 1) homing_ = HomingState::Done;
}

// --- Actual values
// ----------------------------------------------------------------------------------------------------

void Drive402::sample() noexcept {
  // What changed without motion (the world moved something): seen now.
  const std::uint32_t levels = visible(motion_.inputs());
  if (levels != levels_) on_inputs(levels ^ levels_, levels);

  show_position();
  demand_.value = static_cast<std::int32_t>(motion_.demand());
  velocity_.value = whole(motion_.speed() / facts_.velocity_counts_s);
  std::uint32_t bits = inputs_base_;
  const auto show = [&](std::int8_t bit, std::uint32_t input) {
    if (bit >= 0 && (levels & input) != 0) bits |= 1u << bit;
  };
  show(facts_.input_neg_limit, kNegLimit);
  show(facts_.input_pos_limit, kPosLimit);
  show(facts_.input_home, kHome);
  if (lies_.input_noise != 0) bits ^= static_cast<std::uint32_t>(mix(++noise_)) & lies_.input_noise;
  inputs_.value = bits ^ lies_.inputs_inverted;
  show_probe();
  error_.value = shown_error();
  const bool moves = mode_ == kCsp && (motion_.commands_motion() || std::abs(motion_.speed()) > 1);
  if (mode_ == mode_before_ || ++mode_is_new_for_ > lies_.mode_shown_after) mode_before_ = mode_, mode_is_new_for_ = 0;
  mode_shown_.value =
      moves && lies_.mode_shown_in_motion ? *lies_.mode_shown_in_motion : lies_.mode_shown.value_or(mode_before_);
  if (!status_stuck_) status_.value = (statusword() & ~lies_.status_never) | lies_.status_always;
}

void Drive402::show_position() noexcept {
  const bool torque = state_ == State::OperationEnabled || state_ == State::QuickStopActive;
  const std::int64_t counts = motion_.counts() - (torque ? lies_.load : 0);
  if (++samples_ <= lies_.after) return void(actual_.value = static_cast<std::int32_t>(counts));
  if (lies_.position_dead) return;
  actual_.value = static_cast<std::int32_t>(lies_.position_factor * counts + lies_.position_off);
}

void Drive402::show_probe() noexcept {
  const auto latched = [](std::int64_t status) { return (status & (kProbeRisingLatched | kProbeFallingLatched)) != 0; };
  const bool before = latched(probe_status_.value);
  std::uint16_t status = probe_.status((levels_ & kProbe) != 0);
  const bool ahead = lies_.probe == ProbeLie::AlwaysLatched ||
                     (lies_.probe == ProbeLie::LatchedAtArming && probe_.armed()) ||
                     (lies_.probe == ProbeLie::NeverClears && before);
  if (ahead) status |= kProbeRisingLatched;
  probe_status_.value = status;
  const bool old = lies_.probe == ProbeLie::ValueOfBefore && latched(status);
  if (old) return;  // what stands there is shown until the probe is armed anew
  probe_rising_.value = probe_.rising();
  probe_falling_.value = probe_.falling();
}

std::uint16_t Drive402::shown_error() const noexcept {
  if (fault_code_ != 0) return fault_code_;
  if (state_ == State::OperationEnabled && homing_ != HomingState::Running) {
    if ((levels_ & kPosLimit) != 0)
      if (const auto code = limit_code(facts_, true); code != 0) return code;
    if ((levels_ & kNegLimit) != 0)
      if (const auto code = limit_code(facts_, false); code != 0) return code;
  }
  return warning_code_;
}

std::uint16_t Drive402::statusword() const noexcept {
  std::uint16_t word = 0;
  switch (state_) {
    case State::SwitchOnDisabled:  // the upper byte is that of the next state in every manual's table
      word = static_cast<std::uint16_t>((status_row_.ready & 0xFF00) | kVoltageEnabled | kSwitchOnDisabled);
      break;
    case State::ReadyToSwitchOn: word = status_row_.ready; break;
    case State::SwitchedOn: word = status_row_.switched_on; break;
    case State::OperationEnabled: word = enabled_statusword(status_row_); break;
    case State::QuickStopActive: word = 0x0217; break;  // AMD530B 6.2
    case State::FaultReaction: word = 0x021F; break;
    case State::Fault: word = status_row_.fault; break;
    case State::NotReady:
    case State::Unknown: break;
  }
  if (facts_.status_limit >= 0 && (levels_ & (kNegLimit | kPosLimit)) != 0)
    word = static_cast<std::uint16_t>(word | 1u << facts_.status_limit);
  if (!remote_) word = static_cast<std::uint16_t>(word & ~kRemote);
  return word;
}

std::uint16_t Drive402::enabled_statusword(const config::StatuswordRow& row) const noexcept {
  if (mode_ == kHoming) {
    constexpr std::uint16_t kResult = kTargetReached | kHomingAttained | kHomingError;
    switch (homing_) {
      case HomingState::Idle: return row.enabled;
      case HomingState::Running:
      case HomingState::Stopping: return static_cast<std::uint16_t>(row.running & ~kResult);
      case HomingState::Done:
        return static_cast<std::uint16_t>((row.reached & ~kResult) | kTargetReached | kHomingAttained);
      case HomingState::Failed:
        return static_cast<std::uint16_t>((row.reached & ~kResult) | kTargetReached | kHomingError);
    }
  }
  const std::uint16_t word = motion_.commands_motion() || std::abs(motion_.speed()) > 1 ? row.running : row.enabled;
  const bool held_back = mode_ == kCsp && facts_.status_follows >= 0 && motion_.held_back();
  return held_back ? static_cast<std::uint16_t>(word & ~(1u << facts_.status_follows)) : word;
}

// --- Commands
// ---------------------------------------------------------------------------------------------------------

void Drive402::take(double cycle_s, bool remote) noexcept {
  remote_ = remote;
  const auto control = static_cast<std::uint16_t>(remote ? controlword_.value : 0);
  if (state_ != State::OperationEnabled || homing_ != HomingState::Running) take_mode();
  probe_.take(static_cast<std::uint16_t>(probe_function_.value));
  step_state(control);
  if (state_ == State::OperationEnabled) {
    if (mode_ == kCsp && !lies_.ignores_targets) follow_target(cycle_s);
    if (mode_ == kHoming) take_homing(control);
  }
  last_control_ = control;
}

void Drive402::take_mode() noexcept {
  const auto wanted = static_cast<std::int8_t>(mode_wanted_.value);
  if (wanted == mode_) return void(mode_wanted_for_ = 0);
  if (++mode_wanted_for_ <= lies_.mode_delay) return;
  if (std::find(facts_.modes.begin(), facts_.modes.end(), wanted) == facts_.modes.end()) return;
  mode_ = wanted;
  status_row_ = row_of(facts_, mode_);
  homing_ = HomingState::Idle;
  motion_.hold();
  target_counts_ = motion_.demand();
}

void Drive402::step_state(std::uint16_t control) noexcept {
  const Command command = decode(control);
  const bool reset = (control & kFaultReset) != 0 && (last_control_ & kFaultReset) == 0;
  if (control == 0) needs_zero_control_ = false;
  if (reset && state_ == State::Fault && !power_cycle_needed_) {
    fault_code_ = 0;
    emergency_ = kNoError;
    disable();
    return;
  }
  if (reset) warning_code_ = 0;
  switch (state_) {
    case State::SwitchOnDisabled:
      if (lies_.enables_unasked && remote_) return enable();
      if (command == Command::Shutdown && !needs_zero_control_) state_ = State::ReadyToSwitchOn;
      break;
    case State::ReadyToSwitchOn:
      if (command == Command::SwitchOn || command == Command::EnableOperation) state_ = State::SwitchedOn;
      if (command == Command::DisableVoltage || command == Command::QuickStop) disable();
      break;
    case State::SwitchedOn:
      enabling_ = command == Command::EnableOperation ? enabling_ + 1 : 0;
      if (enabling_ > lies_.enable_delay || lies_.enables_unasked) enable();
      if (command == Command::Shutdown) state_ = State::ReadyToSwitchOn;
      if (command == Command::DisableVoltage || command == Command::QuickStop) disable();
      break;
    case State::OperationEnabled:
      if (command == Command::SwitchOn) motion_.let_go(), state_ = State::SwitchedOn;
      if (command == Command::Shutdown) motion_.let_go(), state_ = State::ReadyToSwitchOn;
      if (command == Command::DisableVoltage) disable();
      if (command == Command::QuickStop) quick_stop();
      break;
    case State::QuickStopActive:
      if (command == Command::DisableVoltage) disable();
      // Transition 16, for the options that stay in this state.
      if (command == Command::EnableOperation && quick_option_.value >= 5 && !needs_zero_control_) enable();
      break;
    case State::NotReady:
    case State::FaultReaction:
    case State::Fault:
    case State::Unknown: break;
  }
}

void Drive402::enable() noexcept {
  state_ = State::OperationEnabled;
  enabling_ = 0;
  if (lies_.reverts)
    if (Object* o = objects_.find(*lies_.reverts)) o->value = o->facts->initial;
  homing_ = HomingState::Idle;
  after_stop_ = AfterStop::Nothing;
  if (std::abs(motion_.deviation()) > 1 || motion_.is_free()) motion_.anchor();
  target_counts_ = motion_.demand();
  for (const auto& [input, direction] : {std::pair{kPosLimit, +1}, std::pair{kNegLimit, -1}}) {
    motion_.release(direction);
    if ((levels_ & input) != 0) motion_.block(direction);
  }
}

void Drive402::disable() noexcept {
  leave();
  motion_.let_go();
}

void Drive402::leave() noexcept {
  state_ = State::SwitchOnDisabled;
  homing_ = HomingState::Idle;
  after_stop_ = AfterStop::Nothing;
}

double Drive402::decel_counts_s2(const Object& o) const noexcept {
  return static_cast<double>(o.value) * facts_.acceleration_counts_s2;
}

// 605Ah (AMD530B 8.4; iD286 and STD402EC state no options, they are taken as CiA 402 has them: 0 takes the torque).
void Drive402::quick_stop() noexcept {
  const auto option = quick_option_.value;
  if (lies_.coasts) return disable();
  if (option == 0 && ((facts_.quick_stop_options & 1u) == 0 || (facts_.quick_stop_coasts & 1u) != 0)) return disable();
  homing_ = HomingState::Idle;
  state_ = State::QuickStopActive;
  after_stop_ = option >= 5 ? AfterStop::Nothing : AfterStop::Disable;
  if (option == 0 || option == 4 || option == 8)
    motion_.hold();
  else if (option == 1 || option == 5)
    motion_.brake(decel_counts_s2(deceleration_));
  else
    motion_.brake(decel_counts_s2(quick_deceleration_));
  needs_zero_control_ = facts_.quick_stop_needs_toggle && option >= 5 && option <= 7;
}

void Drive402::fault(std::uint16_t code) noexcept {
  if (faulted()) return;
  fault_code_ = code;
  emergency_ = code;
  homing_ = HomingState::Idle;
  state_ = State::FaultReaction;
  after_stop_ = AfterStop::Fault;
  motion_.brake(decel_counts_s2(quick_deceleration_));
}

void Drive402::outputs_lost(bool orderly) noexcept {
  if (state_ != State::OperationEnabled && state_ != State::QuickStopActive) {
    if (!faulted()) disable();
    return;
  }
  if (!orderly) return fault(facts_.bus_loss_code);
  homing_ = HomingState::Idle;
  state_ = State::QuickStopActive;
  after_stop_ = AfterStop::Disable;
  motion_.brake(decel_counts_s2(quick_deceleration_));
}

void Drive402::inject(std::uint32_t code) noexcept {
  const auto* row = error_row(facts_, code);
  const auto short_code = static_cast<std::uint16_t>(code);
  switch (row != nullptr ? row->kind : DriveErrorKind::Fault) {
    case DriveErrorKind::Warning:
    case DriveErrorKind::Limit: warning_code_ = short_code; return;
    case DriveErrorKind::EmergencyInput:  // a warning that takes the torque away (iD286 3.8.3: immediate stop)
      warning_code_ = short_code;
      motion_.hold();
      return leave();
    case DriveErrorKind::PowerCycle: power_cycle_needed_ = true; return fault(short_code);
    case DriveErrorKind::Fault:
    case DriveErrorKind::Undervoltage: return fault(short_code);
  }
}

std::optional<std::uint16_t> Drive402::take_emergency() noexcept {
  const auto code = emergency_;
  emergency_.reset();
  return code;
}

void Drive402::follow_target(double cycle_s) noexcept {
  // Targets are 32 bit and wrap; the nearest one to the last is meant.
  const auto wrapped = static_cast<std::uint32_t>(target_.value) - static_cast<std::uint32_t>(target_counts_);
  target_counts_ += static_cast<std::int32_t>(wrapped);
  motion_.follow(target_counts_, cycle_s);
}

}  // namespace gantry::sim
