#include "app/cycle/supervisor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "app/cycle/interlocks.hpp"

namespace gantry::cycle {
namespace {

constexpr int kFollowingCycles = 3;               // R33: at most 3 cycles over the window
constexpr Time kStrays = milliseconds(100);       // R43: a drive says so for as long, also after a change of its mode
constexpr CycleIndex kClockCycles = 10;           // R10: cycles beyond a bound
constexpr Time kClockCalm = milliseconds(100);    // within it after which that is over
constexpr Time kBrakeCloses = milliseconds(500);  // R53: until then an axis may still sink into its brake

/// A block goes on along its path, also one that is on its way to a hold.
constexpr bool on_path(State s) noexcept { return s == State::Running || s == State::Holding; }

std::int32_t clamp_i32(double v) { return static_cast<std::int32_t>(std::fmin(std::fmax(v, -2e9), 2e9)); }

}  // namespace

Findings Supervisor::look(const View& view) noexcept {
  Findings found;
  look_at_time(view, found);
  look_at_bus(view, found);
  look_at_clocks(view, found);
  if (!operational_) return found;
  look_at_drives(view, found);
  look_at_axes(view, found);
  look_at_inputs(view, found);  // bits of a station that did not take part are as they were
  return found;
}

void Supervisor::look_at_time(const View& view, Findings& found) noexcept {
  const auto missed = static_cast<int>(view.beat.elapsed - 1 + view.beat.still);
  const Time late = view.beat.woke - view.beat.due + missed * setup_.period;  // since the cycle that was slept through
  const std::int64_t window = std::clamp<std::int64_t>(setup_.late_window, 1, kMostInLateWindow);
  for (std::int64_t i = std::min<std::int64_t>(missed + 1, window); i > 0; --i) {
    late_at_ = (late_at_ + 1) % static_cast<std::size_t>(window);
    late_in_window_ -= late_[late_at_] ? 1 : 0;
    late_[late_at_] = false;
  }
  if (missed > 0 || late > setup_.period * 2 / 5) {
    late_[late_at_] = true;
    ++late_in_window_;
    found.push_back({Fault::LateCycle, kNoAxis, static_cast<std::int32_t>(late.count() / 1000)});
  }
  if (view.compute > setup_.period)
    found.push_back(
        {Fault::CycleOverrun, kNoAxis, static_cast<std::int32_t>((view.compute - setup_.period).count() / 1000)});
  if (missed > setup_.stop_after_missed)
    found.push_back({Fault::ControllerStalled, kNoAxis, missed});
  else if (late_in_window_ >= setup_.late_max)
    found.push_back({Fault::LateCycles, kNoAxis, late_in_window_});
}

void Supervisor::look_at_bus(const View& view, Findings& found) noexcept {
  const devices::Exchange& x = view.exchange;
  // A run of bad cycles is told at its beginning; from its bound on it stands for as long as it lasts, so that a reset
  // does not hide it.
  if (x.fault == Fault::FrameLost) {
    ++frames_lost_;
    if (frames_lost_ >= setup_.frames_lost_max && operational_)
      found.push_back({Fault::FramesLost, kNoAxis, frames_lost_});
    else if (frames_lost_ == 1)
      found.push_back({Fault::FrameLost, kNoAxis, frames_lost_});
    return;
  }
  if (x.fault == Fault::BusDown && operational_) found.push_back({Fault::BusDown, kNoAxis, 0});
  if (x.fault == Fault::None || x.fault == Fault::TooManyTookPart) frames_lost_ = 0;
  if (x.fault == Fault::TooFewTookPart) {
    ++counter_low_;
    if (operational_ && counter_low_ >= setup_.counter_low_max)
      found.push_back({Fault::StationSilent, kNoAxis, x.detail});
    else if (operational_ && counter_low_ == 1)
      found.push_back({Fault::TooFewTookPart, kNoAxis, x.detail});
  } else {
    counter_low_ = 0;
  }
  if (x.fault == Fault::TooManyTookPart && operational_) found.push_back({Fault::TooManyTookPart, kNoAxis, x.detail});
  if (operational_ && x.fault == Fault::None && !x.operational)
    found.push_back({Fault::StationLeftOp, kNoAxis, x.detail});
  if (!operational_ && x.fault == Fault::None && x.operational) operational_ = true;
}

bool Supervisor::lasts(Apart& apart, bool beyond, CycleIndex now) const noexcept {
  if (apart.since >= 0 && (now - apart.last) * setup_.period > kClockCalm) apart = {};
  if (!beyond) return false;
  if (apart.since < 0) apart.since = now;
  apart.last = now;
  return now - apart.since >= kClockCycles;
}

/// Clocks count only while every station is operational and takes part: one that is on its way there is still being
/// set.
void Supervisor::look_at_clocks(const View& view, Findings& found) noexcept {
  const devices::Exchange& x = view.exchange;
  if (!operational_ || x.fault != Fault::None || !x.operational) {
    if (clocks_asked_) drifts_.fill({}), lost_.fill({});
    clocks_asked_ = false;
    return;
  }
  const std::size_t i = x.clock_station.value;
  if (!x.clock_seen || i >= drifts_.size()) return;
  clocks_asked_ = true;
  const std::int64_t off = std::abs(std::int64_t{x.clock_ns});
  if (lasts(drifts_[i], off > setup_.clock_note_ns, view.beat.cycle) && !drifts_[i].told) {
    drifts_[i].told = true;
    found.push_back({Fault::DcNotLocked, kNoAxis, x.clock_ns, x.clock_station});
  }
  // For as long as it lasts, so that a reset does not hide it.
  if (lasts(lost_[i], off > setup_.clock_stop_ns, view.beat.cycle))
    found.push_back({Fault::DcLost, kNoAxis, x.clock_ns, x.clock_station});
}

void Supervisor::look_at_drives(const View& view, Findings& found) noexcept {
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    const devices::Feedback& drive = view.axes.drive(d);
    if (drive.fresh && drive.fault == Fault::None && view.axes.dropped(d) && !dropped_[d])
      found.push_back({Fault::DriveDropped, setup_.drives[d].axis, drive.statusword, setup_.drives[d].station});
    dropped_[d] = view.axes.dropped(d);
    if (!drive.fresh || drive.fault == Fault::None) continue;
    // An axis that stands on its switch must be let have torque, and homing meets the switches on purpose: it leads
    // off.
    if (drive.fault == Fault::LimitSwitch && !on_path(view.state)) continue;
    // A warning is told once; whatever stops the machine is told for as long as it lasts (the loop latches the first).
    const bool news = drive.error_code != last_code_[d];
    const FaultInfo& row = info(drive.fault);
    if (news || row.reaction != Reaction::Note)
      found.push_back({drive.fault, setup_.drives[d].axis,
                       row.detail == Detail::Statusword ? drive.statusword : drive.error_code,
                       setup_.drives[d].station});
  }
  for (std::size_t d = 0; d < setup_.drives.size(); ++d) {
    if (view.axes.drive(d).fresh) last_code_[d] = view.axes.drive(d).error_code;
    look_at_rest(view, d, found);
  }
}

/// What shows at standstill alone: a switch that is active when torque comes (R36), and a brake that does not hold
/// while there is none (R53).
void Supervisor::look_at_rest(const View& view, std::size_t d, Findings& found) noexcept {
  const DriveSetup& setup = setup_.drives[d];
  const devices::Feedback& drive = view.axes.drive(d);
  const bool torque = has_torque(drive.state);
  if (drive.fresh && torque && !torque_[d] && (drive.neg_limit || drive.pos_limit))
    found.push_back({Fault::LimitSwitchStuck, setup.axis, 0, setup.station});
  if (drive.fresh) torque_[d] = torque;
  Rest& rest = rest_[d];
  if (torque || !drive.fresh || drive.jumped) {
    rest.since = -1;
    return;
  }
  if (setup.brake_give == 0) return;
  const bool by_fault = drive.state == devices::DriveState::Fault || drive.state == devices::DriveState::FaultReaction;
  if (rest.since < 0) rest = {view.beat.cycle, drive.position, setup.axis == setup_.brake_axis && !by_fault};
  if ((view.beat.cycle - rest.since) * setup_.period < kBrakeCloses) {
    if (!rest.held) rest.at = drive.position;
    return;
  }
  const double moved = drive.position - rest.at;
  if (std::abs(moved) <= setup.brake_give) return;
  found.push_back({Fault::BrakeDrift, setup.axis, clamp_i32(moved * 1000), setup.station});
  rest.at = drive.position;  // and again when it goes on
}

void Supervisor::look_at_axes(const View& view, Findings& found) noexcept {
  for (std::size_t i = 0; i < setup_.axes.size(); ++i) {
    const AxisSetup& axis = setup_.axes[i];
    const AxisId id{static_cast<std::uint8_t>(i)};
    if (!axis.streamed || !view.axes.fresh(id)) continue;
    const bool homing = view.state == State::Homing;
    if (view.axes.measures_following(id) && !homing) {
      const double error = view.axes.behind(id);
      const double window = axis.following_base + axis.following_per_speed_s * std::abs(view.axes.speed(id));
      over_window_[i] = std::abs(error) > window ? over_window_[i] + 1 : 0;
      if (over_window_[i] >= kFollowingCycles) found.push_back({Fault::FollowingError, id, clamp_i32(error * 1000)});
    } else {
      over_window_[i] = 0;
    }
    look_at_targets(view, id, found);
    if (!homing && axis.skew_max > 0 && view.axes.enabled(id) && view.axes.skew(id) > axis.skew_max)
      found.push_back({Fault::GantrySkew, id, clamp_i32(view.axes.skew(id) * 1000)});
    if (on_path(view.state) && view.axes.on_limit(id)) found.push_back({Fault::LimitSwitch, id, 0});
  }
}

/// An enabled drive that does not go where it is sent (R43): an open-loop one by the command that it carries out, any
/// by its statusword. In homing the drive moves by itself, so this is not looked at. One that stands on its switch may
/// be led off, whatever it says there.
void Supervisor::look_at_targets(const View& view, AxisId id, Findings& found) noexcept {
  const double by = view.state == State::Homing ? 0 : view.axes.stops_short(id);
  short_[id.value] = by != 0 ? short_[id.value] + 1 : 0;
  const double target = view.target[id.value];
  if (short_[id.value] >= kFollowingCycles)
    found.push_back({Fault::NotFollowing, id, clamp_i32(by * 1000), kNoStation, target});
  const bool judged = on_path(view.state) || (view.state != State::Homing && !view.axes.on_limit(id));
  for (const std::uint8_t d : setup_.axes[id.value].drives) {
    strayed_[d] = judged && !view.axes.drive(d).follows ? strayed_[d] + 1 : 0;
    if (strayed_[d] * setup_.period > kStrays)
      found.push_back({Fault::NotFollowing, id, clamp_i32((target - view.axes.drive(d).position) * 1000),
                       setup_.drives[d].station, target});
  }
}

/// Interlocks. Without torque nothing can move, and enabling asks for them itself. In setup the door may be open, and
/// only a slow jog may play, or a walk, which plays nowhere else.
void Supervisor::look_at_inputs(const View& view, Findings& found) noexcept {
  if (view.state == State::Offline || view.state == State::Disabled) return;
  const bool setup_mode = in_setup(setup_, view.inputs);
  for (const Interlock& lock : kInterlocks)
    if (is_open(lock, setup_, view.inputs)) found.push_back({lock.open});
  if (setup_mode && view.state == State::Homing) found.push_back({Fault::ModeChanged});
  const bool plays = on_path(view.state) || view.state == State::Held;
  if (!plays) return;
  if (view.purpose == Purpose::Job && (view.inputs & setup_.clamp_mask) != setup_.clamp_mask)
    found.push_back({Fault::ClampOpen});
  const bool walks = view.purpose == Purpose::Walk;
  const bool wrong_mode = setup_mode ? !plays_in_setup(view.purpose) : walks && setup_.mode_mask != 0;
  if (wrong_mode) found.push_back({Fault::ModeChanged});
}

}  // namespace gantry::cycle
