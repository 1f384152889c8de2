// What the cycle of the bus asks of stations and axes, and whether the windows that watch an axis can hold what a sound
// axis does, and bite before nothing else is left to bite.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "config/machine_file.hpp"

namespace gantry::config {
namespace {

using written::AxisRow;
using written::MachineFile;

constexpr double kRounding = 1e-9;       // relative
constexpr int kMostDelay_cycles = 61;    // that are compensated (motion/rt/compensation.hpp)
constexpr double kSameDelay_s = 0.1e-3;  // of stated and virtual delay
constexpr double kLeastCounts = 2;       // as far apart as squared sides may be
constexpr double kSidesPart = 2;         // windows: one side may be behind by one while the other is ahead by one

std::string shown(const Axis& axis, double value, std::string_view per = "") {
  constexpr int kDigits = 4;
  return in_units(axis, value, per, kDigits);
}

/// Stations whose watchdog bites before `tolerated_ms` are over.
void check_watchdogs(const Machine& m, double tolerated_ms, std::string_view what, Location location,
                     Mistakes& mistakes) {
  std::vector<std::string> bite_early;
  for (const Station& s : m.stations)
    if (s.bus == BusKind::EtherCat && s.profile.watchdog_ms <= tolerated_ms)
      bite_early.push_back(fmt::format("'{}' ({} ms)", s.name, s.profile.watchdog_ms));
  if (bite_early.empty()) return;
  mistakes.add(Fault::Inconsistent,
               fmt::format("{} of {:.6g} ms is tolerated, but watchdogs bite earlier: {}", what, tolerated_ms,
                           fmt::join(bite_early, ", ")),
               location);
}

/// Drives interpolate to a target until the next one comes: no axis answers sooner than a cycle.
void check_delays(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  const double cycle_s = seconds(m.bus.cycle), most_s = kMostDelay_cycles * cycle_s;
  std::vector<std::string> sooner;
  Location first;
  for (std::size_t i = 0; i < m.axes.size(); ++i) {
    const Axis& axis = m.axes[i];
    if (axis.kind != AxisKind::Streamed) continue;
    if (axis.response_delay_s > most_s * (1 + kRounding))
      mistakes.add(Fault::OutOfRange,
                   fmt::format("more than {:.6g} ms cannot be compensated at a cycle of {:.6g} ms; write what `gantry "
                               "commission AXIS` measures, or a longer cycle",
                               most_s * 1e3, cycle_s * 1e3),
                   file.axes[i].response_delay_location);
    if (axis.response_delay_s <= 0 || axis.response_delay_s >= cycle_s * (1 - kRounding)) continue;
    if (sooner.empty()) first = file.axes[i].response_delay_location;
    sooner.push_back(fmt::format("{} ({:.6g} ms)", axis.name, axis.response_delay_s * 1e3));
  }
  if (!sooner.empty())
    mistakes.add(Fault::Inconsistent,
                 fmt::format("drives interpolate over one cycle, so that no axis can answer before its {:.6g} ms are "
                             "over, and these have a shorter response_delay: {}; state what `gantry commission AXIS` "
                             "measures at this cycle, or a shorter cycle",
                             cycle_s * 1e3, fmt::join(sooner, ", ")),
                 sooner.size() > 1 ? file.bus.cycle_s.location : first);
}

/// A sound axis is seen so late: by its answer, and by the cycle until its position is read.
double seen_late_s(const Machine& m, const Axis& axis) { return axis.response_delay_s + seconds(m.bus.cycle); }

double window(const Axis& axis, double speed) { return axis.following_base + axis.following_per_speed_s * speed; }

struct Lag {
  double speed = 0, lag = 0;
};

/// A stop from full speed by the axis' limits, seen from its end.
class Stop {
 public:
  explicit Stop(const Axis& axis)
      : v_(axis.v_max),
        j_(axis.j_max),
        a_(std::min(axis.a_max, std::sqrt(axis.v_max * axis.j_max))),
        bend_s_(a_ / j_),
        lasts_s_(v_ / a_ + bend_s_) {}
  [[nodiscard]] double lasts_s() const { return lasts_s_; }
  /// So long before it stands.
  [[nodiscard]] double speed(double left_s) const {
    if (left_s <= bend_s_) return j_ * left_s * left_s / 2;
    const double since_s = lasts_s_ - left_s;
    if (since_s <= 0) return v_;
    return since_s < bend_s_ ? v_ - j_ * since_s * since_s / 2 : a_ * (left_s - bend_s_ / 2);
  }
  [[nodiscard]] double way(double left_s) const {
    if (left_s <= bend_s_) return j_ * left_s * left_s * left_s / 6;
    const double since_s = lasts_s_ - left_s;
    const double all = v_ * lasts_s_ / 2 - v_ * since_s;
    if (since_s <= 0) return all;
    if (since_s < bend_s_) return all + j_ * since_s * since_s * since_s / 6;
    const double u = left_s - bend_s_;
    return bend_s_ * bend_s_ * j_ * (bend_s_ / 6 + u / 2) + a_ * u * u / 2;
  }

 private:
  double v_, j_, a_, bend_s_, lasts_s_;
};

/// The speed at which the lag comes nearest to the window, or is most beyond it, at full speed, else in a stop: while
/// an axis brakes it still has the speed of so much earlier.
Lag worst_lag(const Axis& axis, double late_s) {
  constexpr int kPlaces = 1000;
  Lag worst{axis.v_max, axis.v_max * late_s};
  if (worst.lag > window(axis, axis.v_max)) return worst;
  const Stop stop(axis);
  for (int n = 0; n < kPlaces; ++n) {
    const double left_s = stop.lasts_s() * n / kPlaces;
    const Lag l{stop.speed(left_s), stop.way(left_s + late_s) - stop.way(left_s)};
    if (l.lag - window(axis, l.speed) > worst.lag - window(axis, worst.speed)) worst = l;
  }
  return worst;
}

/// A position is read in whole counts: what watches it must be wider than they are.
void check_counts(const Axis& axis, double bound, Location location, Mistakes& mistakes) {
  const double least = kLeastCounts / std::abs(axis.counts_per_unit);
  if (bound >= least * (1 - kRounding)) return;
  mistakes.add(
      Fault::OutOfRange,
      fmt::format("less than {:.6g} counts of the drive ({}), which a sound axis is off; write more, or correct "
                  "per_rev",
                  kLeastCounts, shown(axis, least)),
      location);
}

/// An axis that has its full speed within a cycle has no ramp that targets could tell.
void check_ramp(const Machine& m, const Axis& axis, const AxisRow& row, Mistakes& mistakes) {
  const double cycle_s = seconds(m.bus.cycle);
  if (axis.v_max / axis.a_max < cycle_s)
    mistakes.add(Fault::OutOfRange,
                 fmt::format("the axis would have v_max after {:.3g} ms, within one cycle; {} or less would be a ramp",
                             axis.v_max / axis.a_max * 1e3, shown(axis, axis.v_max / cycle_s, "/s^2")),
                 row.a_max.location);
}

void check_following(const Machine& m, const Axis& axis, const AxisRow& row, Mistakes& mistakes) {
  const bool measures = std::ranges::all_of(
      axis.drives, [&](const DriveRef& ref) { return m.stations[ref.station.value].profile.drive->closed_loop; });
  if (!row.following || !measures) return;  // an open loop that is to be watched is told already
  const double late_s = seen_late_s(m, axis);
  const Lag worst = worst_lag(axis, late_s);
  if (worst.lag > window(axis, worst.speed) * (1 + kRounding))
    mistakes.add(
        Fault::Inconsistent,
        fmt::format(
            "at {} the window is {}, and a sound axis is {} behind there (response_delay {:.6g} ms and a cycle of "
            "{:.6g} ms until its position is read): every fast move would stop; write at least base: {}, "
            "per_speed: {:.3g} ms",
            shown(axis, worst.speed, "/s"), shown(axis, window(axis, worst.speed)), shown(axis, worst.lag),
            axis.response_delay_s * 1e3, seconds(m.bus.cycle) * 1e3,
            shown(axis, std::max(axis.following_base, axis.a_max * late_s * late_s)), late_s * 1e3),
        row.following->base.location);
  check_counts(axis, axis.following_base, row.following->base.location, mistakes);
  if (axis.following_base >= axis.p_max - axis.p_min)
    mistakes.add(
        Fault::OutOfRange,
        fmt::format("as wide as the travel of the axis ({}): it watches nothing", shown(axis, axis.p_max - axis.p_min)),
        row.following->base.location);
}

/// The sides of a gantry axis go by one target, each within its window, so that they part by two windows at most.
void check_skew(const Axis& axis, const AxisRow& row, Mistakes& mistakes) {
  if (axis.drives.size() != 2) return;
  if (row.skew_max.given() && axis.skew_max > 0) check_counts(axis, axis.skew_max, row.skew_max.location, mistakes);
  const double most = kSidesPart * window(axis, axis.v_max);
  if (row.following && axis.skew_max >= most)
    mistakes.add(Fault::Inconsistent,
                 fmt::format("its sides cannot part by {} before one of them leaves its following window (twice {} at "
                             "v_max): it watches nothing; write what the beam bears, less than {}",
                             shown(axis, axis.skew_max), shown(axis, most / kSidesPart), shown(axis, most)),
                 row.skew_max.location);
  if (!row.homing) return;
  for (const auto& [at, value] : {std::pair{&row.homing->rack_max, axis.homing->rack_max},
                                  std::pair{&row.homing->square_max, axis.homing->square_max}})
    if (at->given() && (value <= 0 || value >= axis.p_max - axis.p_min))
      mistakes.add(Fault::OutOfRange,
                   fmt::format("must be more than 0, and less than the travel of the axis ({}), or it watches nothing; "
                               "leave it out when in doubt",
                               shown(axis, axis.p_max - axis.p_min)),
                   at->location);
}

/// What is kept from bodies for an axis is no less than 0, and less than would close all of its travel.
void check_path_error(const Machine& m, const Axis& axis, const AxisRow& row, Mistakes& mistakes) {
  if (!row.path_error.given()) return;
  if (axis.path_error < 0 || axis.path_error >= (axis.p_max - axis.p_min) / 2)
    mistakes.add(
        Fault::OutOfRange,
        fmt::format("must be at least 0, and less than half of the travel of the axis ({}), or no path is left",
                    shown(axis, axis.p_max - axis.p_min)),
        row.path_error.location);
  else if (axis.kind != AxisKind::Streamed)
    mistakes.add(Fault::Inconsistent, "a positioned axis follows no path; leave it out", row.path_error.location);
  else if (axis.id != m.x && axis.id != m.y && axis.id != m.z && axis.id != m.c && axis.id != m.u)
    mistakes.add(Fault::Inconsistent,
                 "an axis that has none of the `roles` moves nothing that is kept from bodies; leave it out, or give "
                 "the axis its role",
                 row.path_error.location);
}

/// How far the axis is off its path at full speed by what its delay is known, here or on the simulated machine, to be
/// other than stated.
double off_path(const Machine& m, const Axis& axis) {
  const SimAxis& truth = m.sim.axes[axis.id.value];
  double off_s = std::abs(truth.lag_s + truth.delay_s + seconds(m.bus.cycle) - axis.response_delay_s);
  if (axis.measured)
    off_s = std::max(off_s, std::abs(axis.measured->delay_s - axis.response_delay_s) + axis.measured->within_s);
  return axis.v_max * off_s;
}

}  // namespace

bool check_timing(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  // One value of the bus that stations contradict is one mistake, which names them all.
  const auto cycle_us = static_cast<std::uint32_t>(m.bus.cycle.count() / 1000);
  std::vector<std::string> other_cycles;
  for (const Station& s : m.stations) {
    if (s.bus != BusKind::EtherCat || !s.profile.drive) continue;
    const auto& cycles = s.profile.drive->cycle_times_us;
    if (!cycles.empty() && std::find(cycles.begin(), cycles.end(), cycle_us) == cycles.end())
      other_cycles.push_back(fmt::format("'{}' ({}: {} us)", s.name, s.profile.title, fmt::join(cycles, ", ")));
  }
  if (!other_cycles.empty()) {
    mistakes.add(Fault::Inconsistent,
                 fmt::format("stations that do not support this cycle: {}; write one that all of them do",
                             fmt::join(other_cycles, ", ")),
                 file.bus.cycle_s.location);
    return false;
  }
  const double cycle_ms = seconds(m.bus.cycle) * 1e3;
  check_watchdogs(m, cycle_ms * m.bus.stop_after_missed_hardware, "a stall", file.bus.stop_after_missed.location,
                  mistakes);
  const Location lost =
      file.bus.frames_lost_location.line > 0 ? file.bus.frames_lost_location : file.bus.cycle_s.location;
  check_watchdogs(m, cycle_ms * m.bus.frames_lost_max, "a loss of frames", lost, mistakes);
  check_delays(m, file, mistakes);
  return true;
}

void check_windows(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  for (std::size_t i = 0; i < m.axes.size(); ++i) {
    check_path_error(m, m.axes[i], file.axes[i], mistakes);
    if (m.axes[i].kind != AxisKind::Streamed) continue;
    check_ramp(m, m.axes[i], file.axes[i], mistakes);
    check_following(m, m.axes[i], file.axes[i], mistakes);
    check_skew(m.axes[i], file.axes[i], mistakes);
  }
}

std::vector<std::string> window_notes(const Machine& m) {
  std::vector<std::string> out;
  for (const Axis& axis : m.axes) {
    if (axis.kind != AxisKind::Streamed) continue;
    if (axis.a_max / axis.j_max < seconds(m.bus.cycle))
      out.push_back(fmt::format(
          "warning: axis {} has a_max after {:.2g} ms, within one cycle: its j_max limits nothing, "
          "and the machine is shaken; {} or less would",
          axis.name, axis.a_max / axis.j_max * 1e3, shown(axis, axis.a_max / seconds(m.bus.cycle), "/s^3")));
    const SimAxis& truth = m.sim.axes[axis.id.value];
    const double virtual_s = truth.lag_s + truth.delay_s + seconds(m.bus.cycle);
    if (std::abs(virtual_s - axis.response_delay_s) > kSameDelay_s)
      out.push_back(
          fmt::format("warning: axis {} states a response_delay of {:.6g} ms, and answers after {:.6g} ms on the "
                      "simulated machine (sim: lag, delay, and a cycle): paths there bend by the difference",
                      axis.name, axis.response_delay_s * 1e3, virtual_s * 1e3));
    if (const double off = off_path(m, axis); axis.path_error > 0 && off > axis.path_error * (1 + kRounding))
      out.push_back(
          fmt::format("warning: axis {} states a path_error of {}, and its delay, where it is other than its "
                      "response_delay says, puts it {} off its path at {}: correct response_delay (`gantry commission "
                      "{}` measures it), or write path_error: {}",
                      axis.name, shown(axis, axis.path_error), shown(axis, off), shown(axis, axis.v_max, "/s"),
                      axis.name, shown(axis, off)));
    const bool carries = axis.id == m.x || axis.id == m.y || axis.id == m.z;
    if (carries && axis.following_base > m.clearance_mm)
      out.push_back(
          fmt::format("warning: axis {} may be {} off its target at rest before that is noticed, more than the "
                      "clearance of {:.6g} mm that is kept from bodies; narrow `following`",
                      axis.name, shown(axis, axis.following_base), m.clearance_mm));
    if (axis.drives.size() == 2 && axis.following_base > 0 && axis.skew_max > kSidesPart * axis.following_base)
      out.push_back(
          fmt::format("warning: at rest the sides of axis {} leave their following windows ({}) before they "
                      "part by skew_max ({}): that watches only what is fast",
                      axis.name, shown(axis, axis.following_base), shown(axis, axis.skew_max)));
  }
  return out;
}

}  // namespace gantry::config
