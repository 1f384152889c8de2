// Homing of a virtual drive: the phases of its method (homing_methods.hpp), switch by switch.
#include <algorithm>

#include "sim/drive/drive402.hpp"

namespace gantry::sim {

using namespace devices::wire::cia402;

void Drive402::take_homing(std::uint16_t control) noexcept {
  const bool start = (control & kHomingStart) != 0, was = (last_control_ & kHomingStart) != 0;
  if (start && !was) start_homing();
  if (!start && homing_ == HomingState::Running) {  // bit 4 taken back: stops at once (AMD530B 6.4.1)
    homing_ = HomingState::Idle;
    motion_.brake(decel_counts_s2(homing_acceleration_));
  }
}

void Drive402::start_homing() noexcept {
  const auto number = static_cast<std::int8_t>(homing_method_.value);
  const bool known =
      std::find(facts_.homing_methods.begin(), facts_.homing_methods.end(), number) != facts_.homing_methods.end();
  method_ = known ? homing_method(number) : nullptr;
  homing_ = HomingState::Running;
  if (method_ == nullptr) return fail_homing();
  if (method_->reference == 0 || lies_.home_at_once) {
    motion_.set_counts(home_offset_.value);
    homing_ = HomingState::Stopping;
    return;
  }
  const bool complete = homing_fast_.value > 0 && homing_slow_.value > 0 && homing_acceleration_.value > 0 &&
                        visible(method_->reference) != 0;
  if (!complete) return fail_homing();
  for (const int direction : {+1, -1}) motion_.release(direction);
  phases_ = method_->start_list(levels_);
  may_bounce_ = phases_.data() == method_->off.data() && !method_->bounced.empty();
  if (!lies_.home_never) next_homing_phase();
}

void Drive402::next_homing_phase() noexcept {
  const HomingPhase& phase = phases_.front();
  const Object& speed = phase.fast ? homing_fast_ : homing_slow_;
  motion_.run(phase.direction * static_cast<double>(speed.value) * facts_.velocity_counts_s,
              decel_counts_s2(homing_acceleration_));
  // Standing on a limit ahead: the motor must not start into it.
  const std::uint32_t ahead = phase.direction > 0 ? kPosLimit : kNegLimit;
  if ((levels_ & ahead) != 0 && phase.input != ahead) on_homing_input(ahead, levels_);
}

void Drive402::on_homing_input(std::uint32_t changed, std::uint32_t levels) noexcept {
  const HomingPhase& phase = phases_.front();
  const bool closed = (levels & phase.input) != 0;
  if ((changed & phase.input) != 0 && closed == phase.until_closed) {
    phases_ = phases_.subspan(1);
    may_bounce_ = false;
    if (!phases_.empty()) return next_homing_phase();
    if (!lies_.keeps_counter) motion_.set_counts(home_offset_.value);  // this instant is home
    motion_.brake(decel_counts_s2(homing_acceleration_));
    homing_ = HomingState::Stopping;
    return;
  }
  const std::uint32_t met = changed & levels & (kNegLimit | kPosLimit);
  if (met == 0) return;
  if (may_bounce_ && (met & method_->bounce) != 0) {
    phases_ = method_->bounced;
    may_bounce_ = false;
    return next_homing_phase();
  }
  fail_homing();
}

void Drive402::fail_homing() noexcept {
  homing_ = HomingState::Failed;
  warning_code_ = facts_.homing_code;
  motion_.hold();
}

}  // namespace gantry::sim
