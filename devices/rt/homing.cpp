#include "devices/rt/homing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace gantry::devices {
namespace {

using namespace wire::cia402;

constexpr Time kStands = milliseconds(20);          // without a count of motion
constexpr Time kSilent = milliseconds(100);         // after it a cancelled drive that is not heard of is given up
constexpr Time kPhaseTimeout = milliseconds(1000);  // for entering and leaving the mode and for coming to rest

bool done_bits(const Feedback& f) noexcept {
  return (f.statusword & kTargetReached) != 0 && (f.statusword & kHomingAttained) != 0;
}

}  // namespace

void HomingRun::start(const HomingLimits& limits, const Feedback& feedback) noexcept {
  *this = HomingRun{};
  limits_ = limits;
  phase_cycles_ = kPhaseTimeout / limits.cycle;
  silent_cycles_ = kSilent / limits.cycle;
  stands_cycles_ = std::max<std::int64_t>(kStands / limits.cycle, 2);
  start_ = last_ = feedback.counts;
  guard_ = HomingGuard(limits.rules, feedback);
  edge_ = HomeEdge(limits.rules, limits.edge_counts, feedback);
  phase_ = Phase::EnterMode;
}

void HomingRun::cancel(Fault why) noexcept {
  if (phase_ == Phase::Done) fault_ = why, enter(Phase::Failed);
  if (!busy()) return;
  if (fault_ == Fault::None) fault_ = why;
  // What lasts cancels it in every cycle: the phase that brings it to an end is entered once.
  if (phase_ != Phase::Settle && phase_ != Phase::LeaveMode)
    enter(phase_ == Phase::LeadOff ? Phase::LeaveMode : Phase::Settle);
}

bool HomingRun::stands(const Feedback& f) noexcept {
  if (!f.fresh) return false;  // it may move, unseen
  still_ = f.counts == last_ ? still_ + 1 : 0;
  last_ = f.counts;
  return still_ >= stands_cycles_;
}

bool HomingRun::is_jump(std::int64_t step, std::int64_t cycles) const noexcept {
  constexpr double kJump = 10;  // cycles of travel in one
  return static_cast<double>(std::abs(step)) > kJump * static_cast<double>(cycles) * limits_.rules.counts_per_cycle;
}

void HomingRun::watch_search(const Feedback& f) noexcept {
  if (seen_undone_ && (f.statusword & kHomingError) != 0) return cancel(Fault::HomingFailed);
  if (const Fault seen = guard_.look(f, unseen_); seen != Fault::None) return cancel(seen);
  if (seen_undone_ && done_bits(f)) {
    const bool doubtful = !guard_.found_switch() || counter_is_dead();
    if (doubtful && !at_the_edge()) return cancel(Fault::HomingFailed);
    led_off_ = doubtful;
    return enter(Phase::Settle);
  }
  // The drive sets its counter anew at the home edge, perhaps before it shows "done": that jump is no travel.
  const std::int64_t step = f.counts.value - last_.value;
  if (!is_jump(step, unseen_)) {
    moved_ += step;
    counted_ = counted_ || step != 0;
  }
  if (limits_.travel_counts <= 0) return void(last_ = f.counts);
  if (std::abs(step) > limits_.travel_counts / 10) start_.value += step;
  last_ = f.counts;
  if (std::abs(f.counts.value - start_.value) > limits_.travel_counts) cancel(Fault::HomingTimeout);
}

/// Its switch was not seen, or its counter has not moved, but the distance was so short that it may have stood at its
/// edge when it began.
bool HomingRun::at_the_edge() const noexcept {
  constexpr double kNear = 10;  // cycles of travel
  return !led_off_ && limits_.rules.toward != 0 &&
         static_cast<double>(std::abs(moved_)) <= kNear * limits_.rules.counts_per_cycle;
}

/// Counts from its edge as the drive has them: its counter may have wrapped on the way there, and `counts` has not.
std::int64_t HomingRun::off_edge(const Feedback& f) const noexcept {
  return std::int64_t{wrap(f.counts)} - limits_.home_counts;
}

/// A drive that calls its homing done has set its counter at the edge, and stands near it.
void HomingRun::leave(const Feedback& f) noexcept {
  const std::int64_t off = off_edge(f);
  const bool far = limits_.near_counts > 0 && std::abs(off) > limits_.near_counts;
  if (fault_ == Fault::None && !led_off_ && (far || !edge_.agrees(off))) fault_ = Fault::HomingFailed;
  enter(fault_ != Fault::None ? Phase::Failed : led_off_ ? Phase::LeadOff : Phase::Done);
}

/// Its switch has closed or opened since it began, and 6064h has not moved by a count meanwhile. (An axis that was at
/// its edge may end where it began.)
bool HomingRun::counter_is_dead() const noexcept {
  return !counted_ && limits_.rules.toward != 0 && limits_.rules.counts_per_cycle > 0;
}

void HomingRun::lead_off(const Feedback& f) noexcept {
  constexpr double kBack = 2, kCycles = 32;  // what it travels in two cycles, in so many
  const double all = kBack * limits_.rules.counts_per_cycle;
  if (static_cast<double>(led_) < all) {
    const std::int64_t step = std::max<std::int64_t>(1, std::llround(all / kCycles));  // targets are whole counts
    led_ += step;
    lead_step_ = static_cast<int>(-limits_.rules.toward * step);
    moved_ += lead_step_;
    still_ = 0;
    return;
  }
  if (!stands(f) && in_phase_ < phase_cycles_) return;
  guard_ = HomingGuard(limits_.rules, f);
  edge_ = HomeEdge(limits_.rules, limits_.edge_counts, f);
  seen_undone_ = ready_ = false;
  start_ = last_ = f.counts;
  enter(Phase::EnterMode);
}

DriveCommand HomingRun::step(const Feedback& f, std::int64_t elapsed, bool may_search) noexcept {
  DriveCommand command{.goal = DriveGoal::Enabled, .mode = kHoming, .target = f.position};
  ++cycles_;
  ++in_phase_;
  unseen_ += elapsed;
  if (busy() && f.state != DriveState::OperationEnabled && f.fresh) {  // torque is gone: nothing to bring to rest
    if (fault_ == Fault::None) fault_ = f.fault != Fault::None ? f.fault : Fault::HomingFailed;
    enter(Phase::Failed);
  }
  if (busy() && fault_ != Fault::None && unseen_ > silent_cycles_)
    enter(Phase::Failed);  // nobody hears what it is told
  lead_step_ = 0;
  const bool in_mode = f.mode == kHoming;
  if (f.fresh && in_mode && !done_bits(f) && (f.statusword & kHomingError) == 0) seen_undone_ = true;
  switch (phase_) {
    case Phase::EnterMode:
      // Bits of an earlier homing vanish while bit 4 is 0; a drive that keeps them is started all the same and must
      // take them back then.
      ready_ = in_mode && (seen_undone_ || in_phase_ > phase_cycles_ / 2);
      if (ready_ && may_search)
        enter(Phase::Search);
      else if (in_phase_ > phase_cycles_)
        cancel(Fault::WrongMode);
      break;
    case Phase::Search:
      if (f.fresh) edge_.look(f, unseen_), watch_search(f);
      if (phase_ == Phase::Search && cycles_ > limits_.timeout_cycles) cancel(Fault::HomingTimeout);
      break;
    case Phase::Settle:
      // A switch that is shown late is waited for.
      if (f.fresh) edge_.look(f, unseen_);
      if ((stands(f) && (fault_ != Fault::None || led_off_ || edge_.agrees(off_edge(f)))) || in_phase_ > phase_cycles_)
        enter(Phase::LeaveMode);
      break;
    case Phase::LeaveMode:
      if (f.takes_targets)
        leave(f);
      else if (in_phase_ > phase_cycles_)
        fault_ = Fault::WrongMode, enter(Phase::Failed);
      break;
    case Phase::LeadOff: lead_off(f); break;
    case Phase::Idle:
    case Phase::Done:
    case Phase::Failed: break;
  }
  if (f.fresh) unseen_ = 0;
  if (phase_ == Phase::Search) command.mode_bits = kHomingStart;
  if (phase_ != Phase::EnterMode && phase_ != Phase::Search && phase_ != Phase::Settle) command.mode = kCsp;
  if (phase_ == Phase::Failed && f.state != DriveState::OperationEnabled) command.goal = DriveGoal::Disabled;
  return command;
}

}  // namespace gantry::devices
