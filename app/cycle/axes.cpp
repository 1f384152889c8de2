#include "app/cycle/axes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gantry::cycle {

using devices::DriveGoal;
using devices::DriveState;

namespace {
constexpr double kJumpCycles = 4;         // R44: cycles of travel at full speed that one cycle may show
constexpr std::int64_t kReportDelay = 2;  // cycles from a target that is sent to a position that tells of it
// What a drive's filter may take to let a target through, in delays of the axis; and cycles in which frames may be
// lost.
constexpr double kDelays = 3;
constexpr std::int64_t kLate = 10;
constexpr double kShortCounts = 20;         // that an open-loop drive may stop short of its target
constexpr Time kStands = milliseconds(10);  // without motion, after which a drive stands
}  // namespace

Axes::Axes(const LoopSetup& setup) noexcept
    : setup_(setup), stands_cycles_(static_cast<int>(std::max<std::int64_t>(kStands / setup.period, 2))) {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    const DriveSetup& drive = setup_.drives[d];
    const AxisSetup& axis = setup_.axes[drive.axis.value];
    // A frame that comes just after SYNC0 makes the drive take two cycles of travel in one, and catch up in the next:
    // that is late, no jump.
    const double travel = setup_.limits.axis[drive.axis.value].v_max * seconds(setup_.period);
    const double step_max = kJumpCycles * travel + axis.following_base;
    drives_[d] =
        devices::Drive(drive.layout, drive.scale, {.cycle = setup_.period, .step_max = step_max, .travel = travel});
  }
}

void Axes::read(const devices::FieldBus& bus, bool answered, bool operational, std::int64_t elapsed) noexcept {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    const StationId station = setup_.drives[d].station;
    const bool fresh = bus.fresh(station);
    const bool was_enabled = drives_[d].feedback().state == DriveState::OperationEnabled;
    const bool had_torque = cycle::has_torque(drives_[d].feedback().state);
    const std::int64_t counts_before = drives_[d].feedback().counts.value;
    const DriveState state =
        drives_[d]
            .read(bus.inputs(station), fresh, elapsed, bus.source(station, setup_.drives[d].digital_inputs),
                  bus.source(station, setup_.drives[d].mode_display))
            .state;
    if (goal_of(d) == DriveGoal::Enabled && was_enabled && state != DriveState::OperationEnabled &&
        state != DriveState::FaultReaction && state != DriveState::Fault)
      dropped_[d] = true;  // set() could throw
    // It counts its commands: a motor that ran on without torque stands elsewhere, and nothing shows where.
    // What moves it at rest (a hand, its weight) is not shown either.
    const bool stood = still_[d] >= stands_cycles_;
    if (had_torque && !cycle::has_torque(state) &&
        !(stood ? setup_.drives[d].keeps_reference : setup_.drives[d].layout.closed_loop))
      forget_reference(setup_.drives[d].axis);
    step_counts_[d] = drives_[d].feedback().counts.value - counts_before;
    unheard_[d] += elapsed;
    if (fresh) {
      apart_cycles_[d] = std::exchange(unheard_[d], 0);
      since_gap_[d] = apart_cycles_[d] > 1 ? 0 : since_gap_[d] + 1;
    }
    const bool moved = std::abs(step_counts_[d]) > 1;  // a count to and fro is no motion
    still_[d] = fresh && !moved ? std::min(still_[d] + 1, stands_cycles_) : 0;
    if (drives_[d].feedback().jumped) {  // whatever else is wrong, and whatever the loop does about that
      forget_reference(setup_.drives[d].axis);
      homing_[d].cancel(Fault::EncoderJump);
    }
    const bool was_away = away_[d] >= setup_.counter_low_max;
    if (!fresh && answered)
      away_[d] = std::min(away_[d] + 1, setup_.counter_low_max);
    else if (fresh && !was_away)
      away_[d] = 0;
    if (was_away || away_[d] < setup_.counter_low_max) continue;
    drives_[d].lose();  // it may come back with another position: it is disabled and no longer referenced
    referenced_ &= ~(1u << setup_.drives[d].axis.value);
  }
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    const auto& drives = setup_.axes[i].drives;
    if (drives.empty()) continue;
    watch_braking(AxisId{static_cast<std::uint8_t>(i)});
    if (const AxisId id{static_cast<std::uint8_t>(i)}; drives.size() == 2) {
      stop_together(id, operational);
      run_out_together(id);
      share_coordinate(id);
      see_lean(id);
    }
    double sum = 0;
    for (const std::uint8_t d : drives) sum += drives_[d].feedback().position;
    actual_[i] = sum / static_cast<double>(drives.size());
  }
}

/// Two sides without a common reference count from where the beam holds them, so that nothing pulls them to the mean of
/// two coordinates that have nothing to do with each other; homing squares them. Both must stand.
void Axes::join(AxisId id, bool second_moves_over) noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  devices::Drive& to = drives_[drives[second_moves_over ? 1 : 0]];
  const devices::Drive& from = drives_[drives[second_moves_over ? 0 : 1]];
  if (cycle::has_torque(to.feedback().state))
    to.call_target(from.commanded());
  else
    to.set_reference({devices::wrap(to.feedback().counts)}, from.feedback().position);
}

/// What one side does that no longer takes targets while the axis moves, the other one does, too: its targets would
/// take it farther, by their jerk and their delay, and rack the beam. One without torque brakes by a ramp of its own,
/// and so does one whose station has left operation. One that has left the line hears nothing more, and stands at the
/// last target that reached it.
void Axes::stop_together(AxisId id, bool operational) noexcept {
  if (goal_ != DriveGoal::Enabled || speed_[id.value] == 0 || (homing_mask_ >> id.value & 1u) != 0) return;
  const auto& drives = setup_.axes[id.value].drives;
  for (std::size_t side = 0; side < 2; ++side) {
    const devices::Feedback& fallen = drives_[drives[side]].feedback();
    const std::uint8_t other = drives[1 - side];
    const bool told = ((stands_with_side_ | stops_with_side_) >> other & 1u) != 0;
    if (told || drives_[other].feedback().state != DriveState::OperationEnabled) continue;
    const bool away = away_[drives[side]] >= setup_.counter_low_max;
    const bool brakes = away ? !operational : fallen.fresh && fallen.state != DriveState::OperationEnabled;
    if (away && operational) stands_with_side_ |= 1u << other;
    if (brakes && setup_.drives[other].quick_stop_brakes) stops_with_side_ |= 1u << other;
  }
}

/// A side without torque that goes on farther than the one that brakes is braked by nothing, whatever its drive says of
/// its quick stop: the other one loses its torque, too, and runs out beside it.
void Axes::run_out_together(AxisId id) noexcept {
  constexpr double kOutran = 20;  // counts: noise is one, and after 4 ms a brake is as far behind friction
  const auto& drives = setup_.axes[id.value].drives;
  const auto counts_per_unit = [&](std::uint8_t d) { return std::abs(drives_[d].scale().to_counts_delta(1)); };
  for (std::size_t side = 0; side < 2; ++side) {
    const std::uint8_t off = drives[side], on = drives[1 - side];
    const devices::Feedback &without = drives_[off].feedback(), &with = drives_[on].feedback();
    const bool beside = without.fresh && with.fresh && !cycle::has_torque(without.state) &&
                        cycle::has_torque(with.state) && std::abs(step_counts_[on]) > 1;
    outran_[off] = beside ? std::max(outran_[off] + std::abs(step(off)) - std::abs(step(on)), 0.0) : 0;
    if (outran_[off] * counts_per_unit(off) > kOutran) runs_out_with_side_ |= 1u << on;
  }
}

/// What a drive does by itself nobody has planned: its ramp may be weak, in another unit, or not there. One that has
/// gone farther than it may, or than the other side of its beam, would go on for as long as its limit switch or the
/// stop's time-out lets it: friction and a brake do more.
void Axes::watch_braking(AxisId id) noexcept {
  // At the speed that it had: one side may begin later than the other, which is told when the first one is seen.
  constexpr double kLater_s = 0.006, kLaterCycles = 4, kLeastLater_s = 0.01;
  constexpr Time kCatchesUp = milliseconds(10);  // behind frames that were lost
  const AxisSetup& axis = setup_.axes[id.value];
  Unbraked found;
  bool braked = false, brakes = false, heard = true;
  double from_speed = 0;
  for (const std::uint8_t d : axis.drives) {
    const devices::Feedback& f = drives_[d].feedback();
    OwnBraking& own = braking_[d];
    const bool homes = f.fresh ? stops_homing(d) : stopped_homing_[d];  // as it was heard last
    const BrakingReach& reach = homes ? setup_.drives[d].homing_reach : setup_.drives[d].reach;
    braked = braked || own.busy();
    heard = heard && f.fresh;
    if (f.fresh) {
      if (!cycle::has_torque(f.state)) let_go_ &= ~(1u << d);
      // One that lets go before it stands, whatever its 605Ah said, is on its way to a stop all the same.
      const bool lets_go = own.busy() && !cycle::has_torque(f.state) && f.state != DriveState::Fault;
      const bool by_itself = f.state == DriveState::QuickStopActive || f.state == DriveState::FaultReaction ||
                             lets_go || homes ||
                             (f.state == DriveState::OperationEnabled && goal_of(d) == DriveGoal::QuickStop);
      const double heard_s = seconds(setup_.period) * static_cast<double>(apart_cycles_[d]);
      // What it does from here on is done by another ramp, or its counter was set at its edge.
      if (homes != stopped_homing_[d] || (homes && homing_[d].is_jump(step_counts_[d], apart_cycles_[d]))) own = {};
      stopped_homing_[d] = homes;
      own.see(by_itself && still_[d] < stands_cycles_, f.position, step(d) / heard_s,
              since_gap_[d] * setup_.period < kCatchesUp, heard_s, reach);
    }
    if (!own.busy()) continue;
    brakes = true;
    from_speed = std::max(from_speed, own.from_speed());
    if (own.gone() > reach.of(own.from_speed())) found = {Fault::NotBraking, own.gone(), setup_.drives[d].station};
  }
  const bool in_homing = (homing_mask_ >> id.value & 1u) != 0;  // its sides may come apart by more, and that is watched
  if (axis.drives.size() == 2 && brakes && heard && !in_homing) {
    const double apart = drives_[axis.drives[0]].feedback().position - drives_[axis.drives[1]].feedback().position;
    if (!braked) apart_before_[id.value] = apart;
    const double later_s = std::max(kLeastLater_s, kLater_s + kLaterCycles * seconds(setup_.period));
    const double by = std::abs(apart - apart_before_[id.value]);
    if (found.fault == Fault::None && by > axis.skew_max + later_s * from_speed)
      found = {Fault::GantrySkew, by, kNoStation};
  }
  const bool known = not_braked_[id.value];
  not_braked_[id.value] = brakes && (known || found.fault != Fault::None);
  unbraked_[id.value] = known ? Unbraked{} : found;
  if (known || found.fault == Fault::None) return;
  for (const std::uint8_t d : axis.drives)  // one that its targets brake goes on being braked
    if (braking_[d].busy()) let_go_ |= 1u << d;
}

/// By a ramp of which something is known.
bool Axes::stops_homing(std::size_t d) const noexcept {
  return homing_[d].stopping() && !own_ramp_[d] && drives_[d].feedback().state == DriveState::OperationEnabled &&
         goal_of(d) == DriveGoal::Enabled;
}

/// A side without torque takes over the coordinate of the other one, where there is no reference. Sides that stand
/// farther apart than they may, one of them or both without torque, have lost it: with torque they would be refused.
void Axes::share_coordinate(AxisId id) noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  const devices::Drive &first = drives_[drives[0]], &second = drives_[drives[1]];
  if (!first.feedback().fresh || !second.feedback().fresh) return;
  const bool first_off = !cycle::has_torque(first.feedback().state),
             second_off = !cycle::has_torque(second.feedback().state);
  if (!first_off && !second_off) return;
  const bool stand = still_[drives[0]] == stands_cycles_ && still_[drives[1]] == stands_cycles_;
  if (((first_off && second_off) || stand) && skew(id) > setup_.axes[id.value].skew_max) forget_reference(id);
  if ((referenced_ >> id.value & 1u) == 0) join(id, second_off);
}

void Axes::see_lean(AxisId id) noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  const devices::Drive &first = drives_[drives[0]], &second = drives_[drives[1]];
  if ((homing_mask_ >> id.value & 1u) != 0) return lean_[id.value].forget();
  const int takers = (first.feedback().takes_targets ? 1 : 0) + (second.feedback().takes_targets ? 1 : 0);
  lean_[id.value].see(first.commanded(), second.commanded(), takers);
}

void Axes::write(devices::FieldBus& bus, const AxisVec& target, std::int64_t elapsed) noexcept {
  const double dt = seconds(setup_.period) * static_cast<double>(elapsed);
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    speed_[i] = (target[i] - last_target_[i]) / dt;
    last_target_[i] = target[i];
    lean_[i].step(speed_[i] != 0 && enabled(AxisId{static_cast<std::uint8_t>(i)}),
                  setup_.axes[i].homing.square_speed / 2, setup_.period, elapsed);
  }
  sent_.push(elapsed, target);
  const std::bitset<kMaxDrives> together = may_search();
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    const DriveSetup& setup = setup_.drives[d];
    devices::DriveCommand command;
    if (homing_[d].busy()) command = homing_[d].step(drives_[d].feedback(), elapsed, together[d]);
    const bool stays_off = (away_[d] >= setup_.counter_low_max || dropped_[d]) && goal_ == DriveGoal::Enabled;
    command.goal = stays_off ? DriveGoal::Disabled : goal_of(d);
    // An axis that has come home stands where it is until the others have, too: the interpolator's position is of the
    // time before.
    const bool in_homing = (homing_mask_ >> setup.axis.value & 1u) != 0;
    command.target = in_homing ? drives_[d].commanded() + homing_[d].lead_step() / setup.scale.to_counts_delta(1)
                               : target[setup.axis.value] + lean(d);
    if (in_homing && squaring_[setup.axis.value].busy() && d == setup_.axes[setup.axis.value].drives[1])
      command.target = squaring_[setup.axis.value].step();
    if ((stands_with_side_ >> d & 1u) != 0) command.target = drives_[d].commanded();
    if (d == probe_drive()) command.probe_function = probe_.step(drives_[d].feedback());
    drives_[d].write(bus.outputs(setup.station), command);
  }
}

/// The two sides of an axis begin to search in the same cycle: one that began alone would rack the beam.
std::bitset<kMaxDrives> Axes::may_search() const noexcept {
  std::bitset<kMaxDrives> may;
  for (const AxisSetup& axis : setup_.axes) {
    const bool all = std::all_of(axis.drives.begin(), axis.drives.end(), [&](auto d) { return homing_[d].ready(); });
    for (const std::uint8_t d : axis.drives) may[d] = axis.drives.size() == 1 || all;  // set() could throw
  }
  return may;
}

/// A drive that is to be braked by its targets keeps its torque for that; one that has none gets none.
DriveGoal Axes::goal_of(std::size_t d) const noexcept {
  if (((runs_out_with_side_ | let_go_) >> d & 1u) != 0) return DriveGoal::Disabled;
  if (goal_ == DriveGoal::Enabled && (stops_with_side_ >> d & 1u) != 0) return DriveGoal::QuickStop;
  if (goal_ != DriveGoal::QuickStop || stops_by_itself(d) || (let_stop_ >> d & 1u) != 0) return goal_;
  return drives_[d].feedback().state == DriveState::OperationEnabled ? DriveGoal::Enabled : DriveGoal::Disabled;
}

std::uint32_t Axes::braked_by_targets() const noexcept {
  std::uint32_t mask = 0;
  for (std::size_t d = 0; d < setup_.drives.size(); ++d)
    if (!stops_by_itself(d) && drives_[d].feedback().state == DriveState::OperationEnabled &&
        goal_of(d) == DriveGoal::Enabled)
      mask |= 1u << d;
  return mask;
}

bool Axes::standing() const noexcept {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d)
    if (moves(d)) return false;
  return true;
}

bool Axes::has_torque(AxisId id) const noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  return !drives.empty() && std::all_of(drives.begin(), drives.end(),
                                        [&](std::uint8_t d) { return cycle::has_torque(drives_[d].feedback().state); });
}

bool Axes::all_enabled() const noexcept {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d)
    if (setup_.axes[setup_.drives[d].axis.value].streamed && !drives_[d].feedback().takes_targets) return false;
  return true;
}

bool Axes::all_disabled() const noexcept {
  return std::all_of(drives_.begin(), drives_.begin() + static_cast<std::ptrdiff_t>(setup_.drives.size()),
                     [](const devices::Drive& d) { return !cycle::has_torque(d.feedback().state); });
}

bool Axes::no_fault() const noexcept {
  return std::all_of(drives_.begin(), drives_.begin() + static_cast<std::ptrdiff_t>(setup_.drives.size()),
                     [](const devices::Drive& d) {
                       const DriveState s = d.feedback().state;
                       return s != DriveState::Fault && s != DriveState::FaultReaction;
                     });
}

bool Axes::fresh(AxisId id) const noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  return std::all_of(drives.begin(), drives.end(), [&](std::uint8_t d) { return drives_[d].feedback().fresh; });
}

bool Axes::enabled(AxisId id) const noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  return !drives.empty() &&
         std::all_of(drives.begin(), drives.end(), [&](std::uint8_t d) { return drives_[d].feedback().takes_targets; });
}

std::uint32_t Axes::enabled_mask() const noexcept {
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < setup_.axes.size(); ++i)
    if (has_torque(AxisId{static_cast<std::uint8_t>(i)})) mask |= 1u << i;
  return mask;
}

AxisVec Axes::commanded() const noexcept {
  AxisVec q{};
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    const auto& drives = setup_.axes[i].drives;
    if (drives.empty()) continue;
    double sum = 0, taking = 0;
    int takers = 0;
    for (const std::uint8_t d : drives) {
      const double at = drives_[d].commanded() - lean(d);
      sum += at;
      if (drives_[d].feedback().takes_targets) taking += at, ++takers;
    }
    q[i] = takers > 0 ? taking / takers : sum / static_cast<double>(drives.size());
  }
  return q;
}

double Axes::following(AxisId id, double target) const noexcept {
  double worst = 0;
  for (const std::uint8_t d : setup_.axes[id.value].drives) {
    const double error = target + lean(d) - drives_[d].feedback().position;
    if (std::abs(error) > std::abs(worst)) worst = error;
  }
  return worst;
}

double Axes::behind(AxisId id) const noexcept {
  const AxisSetup& axis = setup_.axes[id.value];
  const std::int64_t allowed = cycles_in(axis.following_per_speed_s, setup_.period) + kReportDelay;
  double worst = 0;
  for (const std::uint8_t d : axis.drives) {
    const double error = sent_.behind(id, drives_[d].feedback().position - lean(d), allowed);
    if (std::abs(error) > std::abs(worst)) worst = error;
  }
  return worst;
}

double Axes::stops_short(AxisId id) const noexcept {
  const AxisSetup& axis = setup_.axes[id.value];
  const std::int64_t allowed = cycles_in(kDelays * axis.response_delay_s, setup_.period) + kLate;
  double worst = 0;
  for (const std::uint8_t d : axis.drives) {
    if (setup_.drives[d].layout.closed_loop || !drives_[d].feedback().takes_targets) continue;
    const double error = sent_.beyond(id, drives_[d].feedback().position - lean(d), allowed);
    const bool is_short = std::abs(drives_[d].scale().to_counts_delta(error)) > kShortCounts;
    if (is_short && std::abs(error) > std::abs(worst)) worst = error;
  }
  return worst;
}

bool Axes::measures_following(AxisId id) const noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  return enabled(id) &&
         std::all_of(drives.begin(), drives.end(), [&](std::uint8_t d) { return setup_.drives[d].layout.closed_loop; });
}

double Axes::skew(AxisId id) const noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  return drives.size() < 2 ? 0
                           : std::abs(drives_[drives[0]].feedback().position - drives_[drives[1]].feedback().position);
}

bool Axes::on_limit(AxisId id) const noexcept {
  const auto& drives = setup_.axes[id.value].drives;
  return std::any_of(drives.begin(), drives.end(), [&](std::uint8_t d) {
    const devices::Feedback& f = drives_[d].feedback();
    return f.neg_limit || f.pos_limit || f.limit_shown;
  });
}

AxisId Axes::first_on_limit() const noexcept {
  for (std::size_t i = 0; i < setup_.axes.size(); ++i)
    if (const AxisId id{static_cast<std::uint8_t>(i)}; on_limit(id)) return id;
  return kNoAxis;
}

void Axes::start_homing(std::uint32_t mask, const devices::FieldBus& bus) noexcept {
  homing_mask_ = mask;
  farther_ = {};
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    const AxisId id = setup_.drives[d].axis;
    if ((mask >> id.value & 1u) == 0) continue;
    referenced_ &= ~(1u << id.value);
    squaring_[id.value] = {};
    apart_[id.value] = 0, ended_by_[id.value] = kNoStation;
    own_ramp_[d] = !bus.has_row(setup_.drives[d].station, setup_.drives[d].homing_ramp);
    homing_[d].start(setup_.axes[id.value].homing.limits, drives_[d].feedback());
  }
}

void Axes::cancel_homing(Fault why) noexcept {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d)
    if (homing_[d].busy()) homing_[d].cancel(why);
  for (Squaring& s : squaring_)
    if (s.busy()) s.fail(why);
}

void Axes::follow_homing() noexcept {
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    if ((homing_mask_ >> i & 1u) == 0 || setup_.axes[i].drives.size() != 2) continue;
    end_together(i);
    watch_sides(i);
    square_homed(i);
  }
}

/// Where one side has given up, the other one does not go on alone.
void Axes::end_together(std::size_t i) noexcept {
  const auto& drives = setup_.axes[i].drives;
  devices::HomingRun &a = homing_[drives[0]], &b = homing_[drives[1]];
  if (a.fault() != Fault::None && b.busy()) b.cancel(a.fault()), ended_by_[i] = setup_.drives[drives[0]].station;
  if (b.fault() != Fault::None && a.busy()) a.cancel(b.fault()), ended_by_[i] = setup_.drives[drives[1]].station;
}

/// Both sides go the same way, to switches that stand square: what one goes farther than the other is how far the beam
/// was racked, or one of them runs away.
void Axes::watch_sides(std::size_t i) noexcept {
  const AxisSetup& axis = setup_.axes[i];
  devices::HomingRun &a = homing_[axis.drives[0]], &b = homing_[axis.drives[1]];
  if (!(a.busy() || b.busy()) || axis.homing.skew_max <= 0) return;
  const auto moved = [&](const devices::HomingRun& run, std::uint8_t d) {
    return static_cast<double>(run.moved()) / drives_[d].scale().to_counts_delta(1);
  };
  const double apart = std::abs(moved(a, axis.drives[0]) - moved(b, axis.drives[1]));
  farther_[i] = apart;
  if (apart <= axis.homing.skew_max) return;
  apart_[i] = apart;
  a.cancel(Fault::GantrySkew);
  b.cancel(Fault::GantrySkew);
}

void Axes::square_homed(std::size_t i) noexcept {
  using Phase = devices::HomingRun::Phase;
  const AxisSetup& axis = setup_.axes[i];
  if (squaring_[i].begun() || homing_[axis.drives[0]].phase() != Phase::Done ||
      homing_[axis.drives[1]].phase() != Phase::Done)
    return;
  for (const std::uint8_t d : axis.drives)
    drives_[d].set_reference(Counts{axis.homing.limits.home_counts}, axis.homing.position);
  const double from = drives_[axis.drives[1]].commanded(), to = drives_[axis.drives[0]].commanded();
  apart_[i] = std::abs(to - from);
  if (apart_[i] > axis.homing.square_max)
    squaring_[i].fail(Fault::GantryNotSquare);
  else
    squaring_[i].start(from, to, axis.homing.square_speed, setup_.period);
}

bool Axes::homing() const noexcept {
  return std::any_of(homing_.begin(), homing_.begin() + static_cast<std::ptrdiff_t>(setup_.drives.size()),
                     [](const devices::HomingRun& run) { return run.busy(); }) ||
         std::any_of(squaring_.begin(), squaring_.end(), [](const Squaring& s) { return s.busy(); });
}

Axes::Homed Axes::homing_failure() const noexcept {
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    if ((homing_mask_ >> i & 1u) == 0) continue;
    Homed failed{.axis = AxisId{static_cast<std::uint8_t>(i)},
                 .detail = static_cast<std::int32_t>(apart_[i] * 1000),
                 .station = ended_by_[i]};
    for (const std::uint8_t d : setup_.axes[i].drives) {
      failed.fault = homing_[d].fault();
      if (failed.fault == Fault::None) continue;
      const devices::Feedback& shows = drives_[d].feedback();
      const Detail unit = info(failed.fault).detail;
      if (unit == Detail::Statusword) failed.detail = shows.statusword;
      if (unit == Detail::DriveCode) failed.detail = shows.error_code;
      if (unit == Detail::Statusword || unit == Detail::DriveCode) failed.station = setup_.drives[d].station;
      return failed;
    }
    failed.fault = squaring_[i].fault(), failed.station = kNoStation;
    if (failed.fault != Fault::None) return failed;
  }
  return {};
}

Axes::Homed Axes::finish_homing() noexcept {
  const Homed first = homing_failure();
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    if ((homing_mask_ >> i & 1u) == 0) continue;
    const auto& drives = setup_.axes[i].drives;
    const bool done = squaring_[i].fault() == Fault::None && std::all_of(drives.begin(), drives.end(), [&](auto d) {
                        return homing_[d].phase() == devices::HomingRun::Phase::Done;
                      });
    if (!done) {
      if (drives.size() == 2) join(AxisId{static_cast<std::uint8_t>(i)}, true);
      continue;
    }
    const HomingSetup& homing = setup_.axes[i].homing;
    if (drives.size() == 1)  // sides have theirs since they were compared
      drives_[drives[0]].set_reference(Counts{homing.limits.home_counts}, homing.position);
    referenced_ |= 1u << i;
  }
  homing_mask_ = 0;
  return first;
}

bool Axes::all_referenced() const noexcept {
  for (std::size_t i = 0; i < setup_.axes.size(); ++i)
    if (setup_.axes[i].streamed && (referenced_ >> i & 1u) == 0) return false;
  return true;
}

std::size_t Axes::probe_drive() const noexcept {
  if (setup_.probe_axis == kNoAxis || setup_.axes[setup_.probe_axis.value].drives.empty()) return kMaxDrives;
  return setup_.axes[setup_.probe_axis.value].drives[0];
}

double Axes::probe_position() const noexcept {
  const std::size_t d = probe_drive();
  return d < kMaxDrives ? drives_[d].scale().to_position(probe_.latched()) : 0;
}

}  // namespace gantry::cycle
