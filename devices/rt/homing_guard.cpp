#include "devices/rt/homing_guard.hpp"

#include <array>
#include <cmath>

namespace gantry::devices {
namespace {

constexpr int kWrongCycles = 3;      // more than an input flickers
constexpr int kWindow = 20;          // cycles over which the speed is taken
constexpr double kTooFast = 1.5;     // of what was asked; a drive overshoots when it starts
constexpr double kSlackCounts = 20;  // in a window: of a motor that is held
constexpr double kCounterSet = 10;   // cycles of travel in one: the counter was set anew, or frames were lost
constexpr int kSets = 3;             // of these in a window: it really goes that fast

struct Row {
  int first, last;
  std::uint8_t may_meet, reference;
};
// IEC 61800-7-201, 10.4: 1, 2 and 17, 18 look for a limit, 3 to 6 and 19 to 22 for the home switch from the side where
// it stands, 7 to 14 and 23 to 30 for the home switch with a limit to turn round at.
constexpr std::array kMethods{
    Row{1, 1, kSwitchNeg, kSwitchNeg},    Row{2, 2, kSwitchPos, kSwitchPos},    Row{3, 6, 0, kSwitchHome},
    Row{7, 10, kSwitchPos, kSwitchHome},  Row{11, 14, kSwitchNeg, kSwitchHome}, Row{17, 17, kSwitchNeg, kSwitchNeg},
    Row{18, 18, kSwitchPos, kSwitchPos},  Row{19, 22, 0, kSwitchHome},          Row{23, 26, kSwitchPos, kSwitchHome},
    Row{27, 30, kSwitchNeg, kSwitchHome},
};

std::uint8_t closed(const Feedback& f) noexcept {
  return static_cast<std::uint8_t>((f.neg_limit ? kSwitchNeg : 0) | (f.pos_limit ? kSwitchPos : 0) |
                                   (f.home ? kSwitchHome : 0));
}

}  // namespace

HomingRules homing_rules(int method) noexcept {
  for (const Row& row : kMethods)
    if (method >= row.first && method <= row.last) return {.may_meet = row.may_meet, .reference = row.reference};
  return {};
}

HomingGuard::HomingGuard(const HomingRules& rules, const Feedback& f) noexcept
    : rules_(rules),
      leaving_(static_cast<std::uint8_t>(closed(f) & (kSwitchNeg | kSwitchPos) & ~rules.may_meet)),
      seen_(closed(f)),
      last_(f.counts) {}

Fault HomingGuard::look(const Feedback& f, std::int64_t elapsed) noexcept {
  const std::uint8_t now = closed(f);
  seen_ |= now;
  leaving_ &= now;
  const auto limits = static_cast<std::uint8_t>(now & rules_.known & (kSwitchNeg | kSwitchPos));
  const bool wrong = (limits & ~rules_.may_meet & ~leaving_) != 0 || limits == (kSwitchNeg | kSwitchPos);
  wrong_ = wrong ? wrong_ + 1 : 0;
  if (wrong_ >= kWrongCycles) return Fault::HomingWrongLimit;

  const double step = std::abs(static_cast<double>(f.counts.value - last_.value));
  last_ = f.counts;
  if (rules_.counts_per_cycle <= 0) return Fault::None;
  // The drive sets its counter anew at the home edge: that is no travel.
  if (step > kCounterSet * static_cast<double>(elapsed) * rules_.counts_per_cycle + kSlackCounts)
    ++sets_;
  else
    travel_ += step;
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
