#include "devices/rt/homing_guard.hpp"

#include <cmath>
#include <cstdlib>

#include "config/homing_method.hpp"

namespace gantry::devices {
namespace {

constexpr int kWindow = 20;          // cycles over which the speed is taken
constexpr double kTooFast = 1.5;     // of what was asked; a drive overshoots when it starts
constexpr double kSlackCounts = 20;  // in a window: of a motor that is held
constexpr double kCounterSet = 10;   // cycles of travel in one: the counter was set anew, or frames were lost
constexpr int kSets = 3;             // of these in a window: it really goes that fast

constexpr std::uint8_t bit(config::HomingSwitch s) noexcept {
  switch (s) {
    case config::HomingSwitch::NegativeLimit: return kSwitchNeg;
    case config::HomingSwitch::PositiveLimit: return kSwitchPos;
    case config::HomingSwitch::Home: return kSwitchHome;
    case config::HomingSwitch::None: break;
  }
  return 0;
}

}  // namespace

std::uint8_t closed_switches(const Feedback& f) noexcept {
  return static_cast<std::uint8_t>((f.neg_limit ? kSwitchNeg : 0) | (f.pos_limit ? kSwitchPos : 0) |
                                   (f.home ? kSwitchHome : 0));
}

HomingRules homing_rules(int number) noexcept {
  const config::HomingMethod method = config::homing_method(number);
  return {.may_meet = bit(method.turns_at), .reference = bit(method.looks_for), .toward = method.toward};
}

HomingGuard::HomingGuard(const HomingRules& rules, const Feedback& f) noexcept
    : rules_(rules),
      stood_on_(static_cast<std::uint8_t>(closed_switches(f) & rules.known & (kSwitchNeg | kSwitchPos))),
      leaving_(static_cast<std::uint8_t>(closed_switches(f) & (kSwitchNeg | kSwitchPos) & ~rules.may_meet)),
      seen_(closed_switches(f)),
      last_(f.counts),
      closed_at_(f.counts) {
  if (f.inputs == InputSource::Absent && rules_.unseen_accepted) rules_.known = 0;
}

/// An axis leaves its reference switch to find the edge. One that never opens is stuck, or it is another one.
bool HomingGuard::stuck(std::uint8_t now, Counts counts, std::int64_t elapsed) noexcept {
  if (rules_.leave_counts <= 0 || (now & rules_.reference & rules_.known & rules_.leaves) == 0) {
    closed_cycles_ = 0;
    closed_at_ = counts;
    return false;
  }
  closed_cycles_ += elapsed;
  return std::abs(counts.value - closed_at_.value) > rules_.leave_counts || closed_cycles_ > rules_.leave_cycles;
}

/// A limit lies at the end of its direction: what opens as the axis goes on that way is shown at the other one's bit.
/// Not where it has gone less than a counter may have been set by unnoticed, which a drive does at that edge.
bool HomingGuard::other_limit_opened(std::uint8_t now) const noexcept {
  const auto opened = static_cast<std::uint8_t>(stood_on_ & ~now);
  const double unsure = kCounterSet * rules_.counts_per_cycle + 2 * kSlackCounts;
  return ((opened & kSwitchPos) != 0 && static_cast<double>(gone_) > unsure) ||
         ((opened & kSwitchNeg) != 0 && static_cast<double>(gone_) < -unsure);
}

Fault HomingGuard::look(const Feedback& f, std::int64_t elapsed) noexcept {
  if (rules_.known != 0 && (f.inputs == InputSource::Silent || f.inputs == InputSource::Absent))
    return Fault::SwitchesUnseen;
  const std::uint8_t now = closed_switches(f);
  seen_ |= now;
  leaving_ &= now;
  const auto limits = static_cast<std::uint8_t>(now & rules_.known & (kSwitchNeg | kSwitchPos));
  const bool wrong = (limits & ~rules_.may_meet & ~leaving_) != 0 || limits == (kSwitchNeg | kSwitchPos);
  wrong_ = wrong ? wrong_ + 1 : 0;
  if (wrong_ >= rules_.flickers_cycles) return Fault::HomingWrongLimit;

  const std::int64_t moved = f.counts.value - last_.value;
  const double step = std::abs(static_cast<double>(moved));
  last_ = f.counts;
  if (rules_.counts_per_cycle <= 0) return Fault::None;
  // The drive sets its counter anew at the home edge: that is no travel.
  if (step > kCounterSet * static_cast<double>(elapsed) * rules_.counts_per_cycle + kSlackCounts) {
    ++sets_;
    closed_at_.value += moved;
  } else {
    travel_ += step, gone_ += moved;
  }
  if (other_limit_opened(now)) return Fault::HomingWrongLimit;
  stood_on_ &= now;
  if (stuck(now, f.counts, elapsed)) return Fault::HomingSwitchStuck;
  in_window_ += elapsed;
  if (in_window_ < kWindow) return Fault::None;
  // A frame that a host held up shows travel whose cycles are counted with the next one, perhaps in the next window:
  // that one is slow then.
  const bool fast = travel_ > kTooFast * static_cast<double>(in_window_) * rules_.counts_per_cycle + kSlackCounts;
  const bool too_fast = (fast && was_fast_) || sets_ >= kSets;
  was_fast_ = fast, travel_ = 0, in_window_ = 0, sets_ = 0;
  return too_fast ? Fault::HomingTooFast : Fault::None;
}

bool HomingGuard::found_switch() const noexcept {
  const auto wanted = static_cast<std::uint8_t>(rules_.reference & rules_.known);
  return (seen_ & wanted) == wanted;
}

}  // namespace gantry::devices
