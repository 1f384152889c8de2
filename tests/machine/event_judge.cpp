#include "tests/machine/event_judge.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace gantry::test {
namespace {

using config::Input;
using cycle::Snapshot;

// The longest that braking may take: Ctrl-C in homing, at override 0.1, with the drives' lag behind their targets.
constexpr CycleIndex kBraking = 600;
constexpr CycleIndex kEndAfterAbort = 15'000, kLongest = 300'000;
constexpr CycleIndex kSettled = 300;    // cycles after which a motor stands on a target that stands
constexpr CycleIndex kTold = 20;        // cycles in which a loss of torque in motion has to be told
constexpr double kCreep = 0.001;        // mm or rad a cycle of an axis that counts as moving by itself: 1 mm/s
constexpr double kMoving = 0.005;       // mm or rad a cycle of an axis that must not lose its torque: 5 mm/s
constexpr double kNoTravel = 2;         // mm or rad a cycle that are no motion: a counter was set
constexpr double kSpeedMargin = 1.05;   // of v_max that a step of the target may show
constexpr double kEnableMoves = 0.002;  // mm: two counts of a beam's side, where homing ends

}  // namespace

Judge::Judge(const config::Machine& machine) : machine_(machine) {
  for (const config::Axis& axis : machine.axes) {
    bool second = false;
    for (const config::DriveRef& ref : axis.drives)
      for (const config::Station& station : machine.stations)
        if (station.id == ref.station && station.cyclic()) {
          drives_[count_++] = {axis.id.value, axis.counts_per_unit, axis.v_max, ref.invert, second};
          second = true;
        }
  }
  taken_until_.fill(-1), pushed_until_.fill(-1), away_until_.fill(-1);
}

void Judge::blame(const Snapshot& s, const std::string& what) {
  if (broken_.empty())
    broken_ = fmt::format("cycle {}, {}, latched {}: {}", s.cycle, cycle::name(s.state),
                          std::string_view(code(s.latched)), what);
}

void Judge::begins(bool moves, CycleIndex now) {
  began_ = now, moves_ = moves, aborted_at_ = -1, travelled_ = {};
  if (moves) resetting_ = false;
}

void Judge::ended() { began_ = -1, rests_since_ = last_.cycle; }

void Judge::abort_taken(CycleIndex now) {
  if (began_ >= 0 && aborted_at_ < 0) aborted_at_ = now;
}

void Judge::torque_taken(std::uint32_t axes, CycleIndex until) {
  for (std::size_t i = 0; i < kMaxAxes; ++i)
    if ((axes >> i & 1u) != 0) taken_until_[i] = std::max(taken_until_[i], until);
}

void Judge::pushed(std::uint32_t axes, CycleIndex until) {
  for (std::size_t i = 0; i < kMaxAxes; ++i)
    if ((axes >> i & 1u) != 0) pushed_until_[i] = std::max(pushed_until_[i], until);
}

void Judge::away(std::uint32_t axes, CycleIndex until) {
  for (std::size_t i = 0; i < kMaxAxes; ++i)
    if ((axes >> i & 1u) != 0) away_until_[i] = std::max(away_until_[i], until);
  torque_taken(axes, until);
  pushed(axes, until);
}

bool Judge::enabled(std::uint16_t statusword) { return (statusword & 0x6F) == 0x27; }
bool Judge::torque(std::uint16_t statusword) { return enabled(statusword) || (statusword & 0x6F) == 0x07; }

void Judge::look(const Snapshot& s) {
  if (s.cycle == last_.cycle) return;
  if (last_.cycle != 0) {
    look_at_torque(s);  // with the speeds of the cycle before: a drive without torque may stand at once
    speed_before_ = speed_;
    for (std::size_t i = 0; i < s.axes; ++i) speed_[i] = s.actual[i] - last_.actual[i];
    look_at_valve(s);
    look_at_motion(s);
    confirm(s);
    if (began_ >= 0 && aborted_at_ >= 0 && s.cycle > aborted_at_ + kEndAfterAbort)
      blame(s, "what was aborted does not end");
    if (began_ >= 0 && s.cycle > began_ + kLongest) blame(s, "what is under way does not end");
  }
  last_ = s;
}

void Judge::suspect(const Snapshot& s, std::size_t drive, std::string what) {
  if (suspicions_[drive].at < 0) suspicions_[drive] = {s.cycle, 0, std::move(what)};
}

void Judge::confirm(const Snapshot& s) {
  constexpr int kReports = 6;
  if (s.working_counter == 0) return;  // no frame came back
  for (std::size_t d = 0; d < count_; ++d) {
    Suspicion& of = suspicions_[d];
    if (of.at < 0) continue;
    if (!enabled(s.statusword[d]))
      of.at = -1;
    else if (++of.reports > kReports)
      blame(s, fmt::format("{} cycles ago {}", s.cycle - of.at, of.what));
  }
}

/// Shut in the frame after: an abort, an input that stops, a state that is a stop; and wherever no block plays. On the
/// way to a hold a feature may be finished, and none is begun.
void Judge::look_at_valve(const Snapshot& s) {
  using enum cycle::State;
  const auto low = [&](Input input) { return (s.inputs & config::bit(input)) == 0; };
  const bool stopped = low(Input::Stop) || low(Input::DoorClosed) || low(Input::AirOk) || low(Input::SafetyOk) ||
                       low(Input::Mode) || s.latched != Fault::None ||
                       (aborted_at_ >= 0 && s.cycle > aborted_at_ + 1) || s.state == Held || s.state == Stopping ||
                       s.state == Stopped;
  const bool open = (s.outputs & config::bit(config::Output::Valve)) != 0;
  if (open && !valve_ && s.state == Holding && holding_) blame(s, "the valve opens on the way to a hold");
  valve_ = open;
  holding_ = s.state == Holding;
  if (!stopped)
    low_since_ = -1;
  else if (low_since_ < 0)
    low_since_ = s.cycle;
  if (!open) return;
  if (low_since_ >= 0 && s.cycle > low_since_ + 1) blame(s, "the valve is open in a stop");
  if (began_ < 0 || !moves_) blame(s, "the valve is open and nothing is under way");
}

void Judge::look_at_motion(const Snapshot& s) {
  const bool aborted = aborted_at_ >= 0 && s.cycle > aborted_at_ + kBraking;
  // The cycle that says held for the first time carries the last target.
  const bool held = s.state == cycle::State::Held && last_.state == cycle::State::Held;
  const bool stands =
      began_ < 0 || !moves_ || aborted || held || s.state == cycle::State::Stopped || s.state == cycle::State::Disabled;
  // A drive homes by itself; when it is done, the sides of a beam, each at its own edge, come to one coordinate.
  if (s.state == cycle::State::Homing) homed_at_ = s.cycle;
  const bool homing = homed_at_ >= 0 && s.cycle <= homed_at_ + 1;
  const bool joins = homed_at_ >= 0 && s.cycle == homed_at_ + 2;
  std::array<double, cycle::kMaxDrives> steps{};
  for (std::size_t d = 0; d < count_; ++d) {
    const Drive& drive = drives_[d];
    if (!enabled(s.statusword[d]) || !enabled(last_.statusword[d]) || excused(away_until_, drive.axis, s.cycle))
      continue;
    steps[d] = static_cast<double>(s.counts[d] - last_.counts[d]) / drive.counts_per_unit * (drive.inverted ? -1 : 1);
    const auto axis = fmt::format("{}{}", machine_.axes[drive.axis].name, drive.second ? " (second side)" : "");
    if (homing) continue;
    const std::size_t other = drive.second ? d - 1 : d + 1;
    const bool side = drive.second || (other < count_ && drives_[other].second);
    const double allowed = side && joins ? kEnableMoves : 0;
    if (std::abs(steps[d]) > drive.v_max * seconds(machine_.bus.cycle) * kSpeedMargin)
      suspect(s, d, fmt::format("the target of {} steps by {:.4f}", axis, steps[d]));
    if (stands && std::abs(steps[d]) > allowed)
      suspect(s, d,
              fmt::format("the target of {} moves by {:.4f} where nothing may move{}", axis, steps[d],
                          aborted ? fmt::format(", {} cycles after an abort", s.cycle - aborted_at_) : ""));
    if (resetting_ && std::abs(steps[d]) > allowed)
      suspect(s, d, fmt::format("a reset moves the target of {} by {:.4f}", axis, steps[d]));
    // What the sides stood apart when they took torque is taken out in motion, at half of the slow speed of homing.
    const auto& homing_row = machine_.axes[drive.axis].homing;
    const double squaring = homing_row && moves_ ? homing_row->slow / 2 * seconds(machine_.bus.cycle) : 0;
    if (drive.second && enabled(s.statusword[d - 1]) && enabled(last_.statusword[d - 1]) &&
        std::abs(steps[d] - steps[d - 1]) > 2 * allowed + squaring + 2.5 / drive.counts_per_unit)
      suspect(s, d,
              fmt::format("the sides of {} are sent different ways: {:.4f} and {:.4f}", axis, steps[d - 1], steps[d]));
  }
  // The axes themselves, by what their drives report: in homing these move without targets. What has mass does not move
  // in one cycle alone: there its coordinate was set.
  const bool settled = (began_ < 0 && s.cycle > rests_since_ + kSettled) || aborted;
  const bool heard = s.inputs_fresh && last_.inputs_fresh && !homing && !joins;
  for (std::size_t i = 0; i < s.axes; ++i) {
    const double now = std::abs(speed_[i]), before = std::abs(speed_before_[i]);
    const bool moves = now > kCreep && before > kCreep && now < kNoTravel && before < kNoTravel;
    if (heard && (moves || before <= kCreep)) travelled_[i] += speed_before_[i];
    if (excused(pushed_until_, i, s.cycle)) continue;
    if (settled && moves)
      blame(s, fmt::format("{} moves by {:.4f} a cycle where nothing may move{}", machine_.axes[i].name, speed_[i],
                           aborted ? fmt::format(", {} cycles after an abort", s.cycle - aborted_at_) : ""));
    if (began_ >= 0 && !moves_ && std::abs(travelled_[i]) > kEnableMoves)
      blame(s,
            fmt::format("{} has moved by {:.4f} by an order that moves nothing", machine_.axes[i].name, travelled_[i]));
  }
}

/// An axis in motion loses its torque by a reaction that says so, or because the world took it; a fault says it either
/// way.
void Judge::look_at_torque(const Snapshot& s) {
  for (std::size_t d = 0; d < count_; ++d) {
    const std::size_t i = drives_[d].axis;
    const bool moved = std::abs(speed_[i]) > kMoving && std::abs(speed_[i]) < kNoTravel;
    if (!torque(last_.statusword[d]) || torque(s.statusword[d]) || !moved) continue;
    torque_lost_ = s.cycle;
    // The safety chain may open behind another fault, which stays the latched one.
    const bool chain_open = (s.inputs & config::bit(Input::SafetyOk)) == 0;
    const bool reaction = s.latched != Fault::None && (chain_open || info(s.latched).reaction >= Reaction::QuickStop);
    if (!reaction && !excused(taken_until_, i, s.cycle))
      blame(s, fmt::format("{} loses its torque at {:.3f} a cycle, statusword {:04X}h after {:04X}h",
                           machine_.axes[i].name, speed_[i], s.statusword[d], last_.statusword[d]));
  }
  if (torque_lost_ >= 0 && s.latched != Fault::None) torque_lost_ = -1;
  if (torque_lost_ >= 0 && s.cycle > torque_lost_ + kTold) {
    blame(s, "torque was lost in motion and no fault says so");
    torque_lost_ = -1;
  }
}

}  // namespace gantry::test
