#include "devices/rt/drive.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::devices {
namespace {

using namespace wire::cia402;

constexpr Time kTransitionTimeout = milliseconds(1000);  // R42
constexpr Time kModeGrace = milliseconds(100);           // a drive may take this long to show another mode
constexpr Time kPolledModeGrace = milliseconds(1000);    // by SDO, when the mailboxes of other stations are slow, too
constexpr int kCatchUp = 5;   // cycles after a stall or lost frames in which the actual position may make up for it
constexpr int kEdgeHold = 4;  // acknowledged cycles for which each level of the reset bit stands

bool bit(std::uint32_t word, std::int8_t number) noexcept { return number >= 0 && (word >> number & 1u) != 0; }

}  // namespace

Drive::Drive(const DriveLayout& layout, const AxisScale& scale, const DriveOptions& options) noexcept
    : layout_(layout),
      scale_(scale),
      step_max_counts_(std::llround(std::abs(scale.to_counts_delta(options.step_max)))),
      travel_counts_(options.travel > 0 ? std::llround(std::abs(scale.to_counts_delta(options.travel)))
                                        : step_max_counts_),
      timeout_cycles_(kTransitionTimeout / options.cycle),
      mode_grace_cycles_(kModeGrace / options.cycle),
      polled_mode_grace_cycles_(kPolledModeGrace / options.cycle) {}

/// Cycles that the next position shows at once: this program slept, or frames were lost. A drive that was not known
/// before has nothing to catch up with.
void Drive::count_missed(bool fresh, std::int64_t elapsed) noexcept {
  missed_ = known_ ? missed_ + elapsed - 1 : 0;
  if (missed_ > 0)
    catching_up_ = kCatchUp;
  else if (fresh && catching_up_ > 0)
    --catching_up_;
}

/// Whether the position has moved farther than the axis can. Not judged: the first reading, and a drive in homing,
/// which sets its counter at the home edge. A drive that shows the homing mode unasked is judged like any other.
/// What a loss excuses does not add up: so much travel as the time allows, and, as long as a drive catches up, all that
/// leads to its target.
bool Drive::judge_step(Counts before) noexcept {
  const bool homing = asked_to_home_ && feedback_.mode == kHoming;
  if (!homing && mode_ != kHoming) asked_to_home_ = false;
  if (!known_ || homing || step_max_counts_ <= 0) return false;
  const std::int64_t step = feedback_.counts.value - before.value, ahead = sent_.value - before.value;
  if (std::abs(step) <= step_max_counts_ + missed_ * travel_counts_) return false;
  const bool to_target = (step > 0) == (ahead > 0) && std::abs(step) <= std::abs(ahead) + step_max_counts_;
  return catching_up_ == 0 || !to_target;
}

const Feedback& Drive::read(std::span<const std::byte> inputs, bool fresh, std::int64_t elapsed,
                            InputSource digital_inputs, InputSource mode) noexcept {
  Feedback& f = feedback_;
  mode_is_polled_ = mode != InputSource::EveryCycle;
  f.inputs = layout_.digital_inputs.mapped() ? digital_inputs : InputSource::Absent;
  count_missed(fresh, elapsed);
  f.fresh = fresh;
  f.jumped = false;
  if (!fresh) {
    ++stale_;
    ++missed_;
    f.fault = Fault::None;
    return f;
  }
  const DriveState before = f.state;
  const Counts counts_before = f.counts;
  const bool gap = !known_ || stale_ > 0;

  f.statusword = layout_.statusword.get(inputs);
  f.state = decode(f.statusword);
  f.mode = layout_.mode_display.get(inputs, mode_);
  f.counts = unwrap_.step(layout_.position.get(inputs));
  f.position = scale_.to_position(f.counts);
  f.error_code = layout_.error_code.get(inputs);
  f.digital_inputs = layout_.digital_inputs.get(inputs);
  f.neg_limit = bit(f.digital_inputs, layout_.neg_limit_bit);
  f.pos_limit = bit(f.digital_inputs, layout_.pos_limit_bit);
  f.home = bit(f.digital_inputs, layout_.home_bit);
  f.limit_shown = bit(f.statusword, layout_.limit_bit);
  f.takes_targets = f.state == DriveState::OperationEnabled && f.mode == kCsp && mode_ == kCsp;
  f.follows = !f.takes_targets || layout_.follows_bit < 0 || bit(f.statusword, layout_.follows_bit);
  f.probe_status = layout_.probe_status.get(inputs);
  f.probe_level = bit(f.probe_status, layout_.probe_level_bit);
  f.probe_rising = Unwrap::near(f.counts.value, layout_.probe_rising.get(inputs));
  f.probe_falling = Unwrap::near(f.counts.value, layout_.probe_falling.get(inputs));

  ++level_held_;
  const bool there = reached(f.state, goal_);
  const auto state_bit = static_cast<std::uint16_t>(1u << static_cast<unsigned>(f.state));
  const bool progress = there || (passed_ & state_bit) == 0;
  passed_ = there ? state_bit : static_cast<std::uint16_t>(passed_ | state_bit);
  waiting_ = progress ? 0 : waiting_ + 1;
  f.jumped = judge_step(counts_before);
  missed_ = 0;
  f.fault = judge(before, gap);
  // A warning must not keep the machine in motion on a position that is wrong.
  if (f.jumped && (f.fault == Fault::None || info(f.fault).reaction < info(Fault::EncoderJump).reaction))
    f.fault = Fault::EncoderJump;
  stale_ = 0;
  known_ = true;
  return f;
}

Fault Drive::judge_code() const noexcept {
  const bool fault_bit = feedback_.state == DriveState::Fault || feedback_.state == DriveState::FaultReaction;
  for (const auto& row : layout_.codes)
    if (row.code == feedback_.error_code && feedback_.error_code != 0)
      return fault_bit || row.without_fault_bit ? row.fault : Fault::None;
  if (!fault_bit) return Fault::None;  // 603Fh may keep the code of a fault that is over
  return feedback_.state == DriveState::Fault && feedback_.error_code == 0 ? Fault::DriveFaultNoCode
                                                                           : Fault::DriveFault;
}

Fault Drive::judge(DriveState before, bool gap) noexcept {
  if (const Fault f = judge_code(); f != Fault::None) return f;
  // Several steps may have passed while inputs were stale.
  if (feedback_.state == DriveState::Unknown || (!gap && !may_follow(before, feedback_.state)))
    return Fault::ImpossibleStatus;
  const std::int64_t mode_grace = mode_is_polled_ ? polled_mode_grace_cycles_ : mode_grace_cycles_;
  if (feedback_.state == DriveState::OperationEnabled && feedback_.mode != mode_ && mode_asked_ > mode_grace)
    return Fault::WrongMode;
  return waiting_ > timeout_cycles_ ? Fault::TransitionTimeout : Fault::None;
}

/// The rising edge of bit 7: each level stands until it has been in several exchanges that came back, so that a lost
/// frame does not swallow it.
std::uint16_t Drive::reset_word() noexcept {
  if (level_held_ < kEdgeHold) return word_;
  level_held_ = 0;
  return next_controlword(feedback_.state, DriveGoal::FaultReset, word_);
}

void Drive::write(std::span<std::byte> outputs, const DriveCommand& command) noexcept {
  const bool resetting = command.goal == DriveGoal::FaultReset && feedback_.state == DriveState::Fault;
  if (command.goal != goal_) {
    goal_ = command.goal;
    waiting_ = 0;
    passed_ = 0;
    level_held_ = 0;
    if (resetting) word_ = kDisableVoltage;  // begin with the low level
  }
  const bool enabled = feedback_.state == DriveState::OperationEnabled && goal_ == DriveGoal::Enabled;
  // Before it has torque a drive may not even have been in OP, where it is told of a mode.
  mode_asked_ = enabled && command.mode == mode_ ? mode_asked_ + 1 : 0;
  mode_ = command.mode;
  if (mode_ == kHoming) asked_to_home_ = true;

  word_ = resetting ? reset_word() : next_controlword(feedback_.state, goal_, word_);
  const auto extra =
      static_cast<std::uint16_t>(enabled ? command.mode_bits & (kNewSetPoint | kChangeAtOnce | kRelative | kHalt) : 0);

  const bool follow = enabled && feedback_.takes_targets && mode_ == kCsp && std::isfinite(command.target);
  // In homing the drive moves by itself. In every other mode that it shows it may be in CSP already, or still: a target
  // that went after its position would sink with a load in every cycle. A drive that says it has torque is believed,
  // also after it was told to give it up: it may not have heard that.
  const bool stands =
      feedback_.state == DriveState::OperationEnabled && !(mode_ == kHoming && feedback_.mode == kHoming);
  if (follow)
    sent_ = scale_.to_counts(command.target);
  else if (!stands || !target_stands_)
    sent_ = feedback_.counts;
  target_stands_ = stands;

  layout_.controlword.set(outputs, static_cast<std::uint16_t>(word_ | extra));
  layout_.mode.set(outputs, mode_);
  layout_.target.set(outputs, wrap(sent_));
  layout_.probe_function.set(outputs, command.probe_function);
}

void Drive::lose() noexcept {
  feedback_.state = DriveState::NotReady;
  feedback_.takes_targets = feedback_.jumped = false;
  unwrap_ = Unwrap{};
  known_ = asked_to_home_ = false;
  stale_ = waiting_ = missed_ = 0;
  catching_up_ = 0;
  passed_ = 0;
  word_ = kDisableVoltage;
}

void Drive::set_reference(Counts home, double position) noexcept {
  feedback_.counts = unwrap_.restart(wrap(feedback_.counts));
  scale_.set_reference(home, position);
  feedback_.position = scale_.to_position(feedback_.counts);
  sent_ = feedback_.counts;
}

void Drive::call_target(double position) noexcept {
  scale_.set_reference(sent_, position);
  feedback_.position = scale_.to_position(feedback_.counts);
}

}  // namespace gantry::devices
