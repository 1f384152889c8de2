#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>

#include "config/machine_file.hpp"

namespace gantry::config {
namespace {

using written::MachineFile;

/// No stepper or servo of this size turns faster (assumed); what is written beyond is another unit or a 0 too many.
constexpr double kMostRevs_s = 200;

void check_stations(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  std::map<std::pair<BusKind, int>, std::string> places;
  int on_ring = 0;
  for (const Station& s : m.stations) on_ring += s.bus == BusKind::EtherCat;
  for (std::size_t i = 0; i < m.stations.size(); ++i) {
    const Station& s = m.stations[i];
    const Place place = file.stations[i].position.place;
    const auto [other, is_new] = places.try_emplace({s.bus, s.position}, s.name);
    if (!is_new)
      mistakes.add(Fault::Inconsistent, fmt::format("'{}' stands at {} already", other->second, s.position), place);
    else if (s.bus == BusKind::EtherCat && s.position >= on_ring)
      mistakes.add(Fault::OutOfRange, fmt::format("the ring has {} stations; positions count from 0", on_ring), place);
    else if (s.bus == BusKind::CanOpen && s.position == 0)
      mistakes.add(Fault::OutOfRange, "CANopen node ids are 1 .. 127", place);
  }
}

/// One value of the bus that stations contradict is one mistake, which names them all.
void check_timing(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  const auto cycle_us = static_cast<std::uint32_t>(m.bus.cycle.count() / 1000);
  const double tolerated_ms = static_cast<double>(m.bus.cycle.count()) * 1e-6 * m.bus.stop_after_missed_hardware;
  std::vector<std::string> other_cycles, bite_early;
  for (const Station& s : m.stations) {
    if (s.bus != BusKind::EtherCat) continue;
    if (s.profile.drive) {
      const auto& cycles = s.profile.drive->cycle_times_us;
      if (!cycles.empty() && std::find(cycles.begin(), cycles.end(), cycle_us) == cycles.end())
        other_cycles.push_back(fmt::format("'{}' ({}: {} us)", s.name, s.profile.title, fmt::join(cycles, ", ")));
    }
    if (s.profile.watchdog_ms <= tolerated_ms)
      bite_early.push_back(fmt::format("'{}' ({} ms)", s.name, s.profile.watchdog_ms));
  }
  if (!other_cycles.empty())
    mistakes.add(Fault::Inconsistent,
                 fmt::format("stations that do not support this cycle: {}", fmt::join(other_cycles, ", ")),
                 file.bus.cycle_s.place);
  if (!bite_early.empty())
    mistakes.add(Fault::Inconsistent,
                 fmt::format("a stall of {} ms is tolerated, but watchdogs bite earlier: {}", tolerated_ms,
                             fmt::join(bite_early, ", ")),
                 file.bus.stop_after_missed.place);
}

void check_axis(const Machine& m, const Axis& axis, const written::AxisRow& row, Mistakes& mistakes) {
  const auto mode = static_cast<std::int8_t>(axis.kind == AxisKind::Streamed ? 8 : 1);
  bool watched = !axis.drives.empty();  // every drive does its part and measures where it is
  for (std::size_t d = 0; d < axis.drives.size(); ++d) {
    const Station& station = m.stations[axis.drives[d].station.value];
    const DriveFacts& drive = *station.profile.drive;
    const bool able = std::find(drive.modes.begin(), drive.modes.end(), mode) != drive.modes.end();
    watched = watched && able && drive.closed_loop;
    if (!able)
      mistakes.add(Fault::Inconsistent,
                   fmt::format("{} cannot be {}: it lacks mode {}", station.profile.title,
                               mode == 8 ? "streamed (write kind: positioned)" : "positioned", mode),
                   row.drives[d].place);
    if (axis.homing && std::find(drive.homing_methods.begin(), drive.homing_methods.end(), axis.homing->method) ==
                           drive.homing_methods.end())
      mistakes.add(Fault::Inconsistent,
                   fmt::format("{} homes by methods {}", station.profile.title, fmt::join(drive.homing_methods, ", ")),
                   row.homing->method.place);
    if (row.following && !drive.closed_loop)
      mistakes.add(
          Fault::Inconsistent,
          fmt::format("{} runs open loop: its position is the command, so there is no following error to watch",
                      station.profile.title),
          row.following->base.place);
  }
  if (watched && axis.kind == AxisKind::Streamed && !row.following)
    mistakes.add(Fault::MissingKey, "'following' is missing here (the window of a closed-loop axis)", row.place);
  if (axis.unit_per_rev > 0 && axis.v_max / axis.unit_per_rev > kMostRevs_s)
    mistakes.add(Fault::OutOfRange,
                 fmt::format("turns the motor at {:.6g} rpm; more than {:.6g} rpm is taken for a slip",
                             60 * axis.v_max / axis.unit_per_rev, 60 * kMostRevs_s),
                 row.v_max.place);
  if (axis.drives.size() == 2 && axis.skew_max <= 0)
    mistakes.add(Fault::MissingKey, "'skew_max' is missing here (a gantry axis must watch its two sides)", row.place);
  if (axis.drives.size() == 1 && row.skew_max.given())
    mistakes.add(Fault::Inconsistent, "one drive has no skew; leave it out", row.skew_max.place);
  if (axis.kind == AxisKind::Streamed && axis.response_delay_s > 0.05)
    mistakes.add(Fault::OutOfRange, "more than 50 ms cannot be compensated", row.place);
}

void check_axes(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  std::map<std::pair<StationId, int>, std::string> taken;
  for (std::size_t i = 0; i < m.axes.size(); ++i) {
    check_axis(m, m.axes[i], file.axes[i], mistakes);
    for (std::size_t d = 0; d < m.axes[i].drives.size(); ++d) {
      const DriveRef& ref = m.axes[i].drives[d];
      const auto [other, is_new] = taken.try_emplace({ref.station, ref.slot}, m.axes[i].name);
      if (!is_new)
        mistakes.add(Fault::Inconsistent, fmt::format("axis '{}' has this drive already", other->second),
                     file.axes[i].drives[d].place);
    }
  }
  for (const auto& [role, name] : {std::pair{m.x, &file.roles.x}, {m.y, &file.roles.y}, {m.z, &file.roles.z}})
    if (m.axes[role.value].kind != AxisKind::Streamed)
      mistakes.add(Fault::Inconsistent, "an axis that carries the head must be streamed", name->place);
  const auto& z_homing = m.axes[m.z.value].homing;
  for (const AxisId id : {m.x, m.y})
    if (const auto& h = m.axes[id.value].homing; h && z_homing && z_homing->order >= h->order) {
      mistakes.add(Fault::Inconsistent,
                   fmt::format("axis {} moves sideways before {} is up; give {} the lowest order",
                               m.axes[id.value].name, m.axes[m.z.value].name, m.axes[m.z.value].name),
                   file.axes[m.z.value].homing->place);
      break;
    }
  if (m.x == m.y || m.y == m.z || m.x == m.z)
    mistakes.add(Fault::Inconsistent, "X, Y and Z must be three axes", file.roles.z.place);
  for (std::size_t i = 0; i < file.park.size(); ++i) {
    const Axis& axis = m.axes[m.park[i].first.value];
    if (m.park[i].second < axis.p_min || m.park[i].second > axis.p_max)
      mistakes.add(Fault::OutOfRange, fmt::format("outside the travel of axis {}", axis.name),
                   file.park[i].quantity.place);
  }
  const Axis& z = m.axes[m.z.value];
  if (m.safe_z_mm < z.p_min || m.safe_z_mm > z.p_max)
    mistakes.add(Fault::OutOfRange, fmt::format("outside the travel of axis {}", z.name), file.safe_z_mm.place);
}

void check_head(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  for (const std::string_view needed : {"needle", "camera", "probe"})
    if (!find_tool(m, needed))
      mistakes.add(Fault::MissingKey, fmt::format("tool '{}' is missing under head: tools:", needed), {1, 1});
  for (const auto& row : file.head.tools) {
    if (!row.lift_mm.given()) continue;
    if (!m.u) {
      mistakes.add(Fault::Inconsistent, "no axis has the role `lift`", row.lift_mm.place);
    } else if (const Axis& u = m.axes[m.u->value]; row.lift_mm.value < u.p_min || row.lift_mm.value > u.p_max) {
      mistakes.add(Fault::OutOfRange, fmt::format("outside the travel of axis {}", u.name), row.lift_mm.place);
    }
  }
  std::set<std::string> names;
  for (const auto& row : file.head.bodies) names.insert(row.name);
  for (const auto& row : file.scene)
    if (names.count(row.name))
      mistakes.add(Fault::DuplicateKey, fmt::format("the head has a body '{}' too; messages name bodies", row.name),
                   row.place);
  const StationProfile& probe = m.stations[m.axes[m.probe.axis.value].drives.front().station.value].profile;
  if (!find_object(probe, {0x60B8, 0}))
    mistakes.add(Fault::Inconsistent, fmt::format("{} has no probe input (60B8h)", probe.title), file.probe.axis.place);
}

void check_sim(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  for (const auto& row : file.sim.axes) {
    const Axis& axis = *find_axis(m, row.name);
    const SimAxis& truth = m.sim.axes[axis.id.value];
    if (truth.neg_limit >= axis.p_min || truth.pos_limit <= axis.p_max)
      mistakes.add(Fault::Inconsistent, fmt::format("limit switches stand outside the travel of axis {}", axis.name),
                   row.limits.place);
    if (truth.start < truth.neg_limit || truth.start > truth.pos_limit)
      mistakes.add(Fault::OutOfRange, "outside the limit switches", row.start.place);
  }
}

}  // namespace

void check_machine(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  check_stations(m, file, mistakes);
  check_timing(m, file, mistakes);
  check_axes(m, file, mistakes);
  check_head(m, file, mistakes);
  check_sim(m, file, mistakes);
  check_drive_limits(m, file, mistakes);
}

std::vector<std::string> assumptions(const Machine& machine) {
  std::vector<std::string> out;
  std::set<std::string> told;
  for (const Station& s : machine.stations) {
    if (!told.insert(s.profile.name).second) continue;
    if (s.profile.identity.assumed)
      out.push_back(fmt::format(
          "{}: identity {:08X}:{:08X} is assumed; a station that answers otherwise is refused until `gantry commission "
          "--accept` has taken it",
          s.profile.title, s.profile.identity.vendor, s.profile.identity.product));
    std::string late;
    for (const Parameter& p : s.profile.parameters)
      if (p.assumed && p.acts == ActsAt::PowerUp) late += (late.empty() ? "" : ", ") + p.name;
    if (!late.empty()) out.push_back(fmt::format("{}: that these act at power-up: {}", s.profile.title, late));
    for (const std::string& sentence : s.profile.assumptions)
      out.push_back(fmt::format("{}: {}", s.profile.title, sentence));
  }
  return out;
}

std::string lost_emergency_stop(const Machine& machine) {
  const Axis& axis = machine.axes[machine.probe.axis.value];
  if (axis.drives.empty()) return "";
  const Station& s = machine.stations[axis.drives.front().station.value];
  if (!s.profile.drive || !s.profile.drive->probe_takes_emergency_stop || s.emergency_stop_elsewhere) return "";
  return fmt::format(
      "station '{}' ({}): the probe takes the input of its emergency stop; wire the emergency stop outside of the "
      "drive, "
      "and write `emergency_stop_elsewhere: true` under stations.{}",
      s.name, s.profile.title, s.name);
}

std::string not_stated(const Station& s) {
  return fmt::format("station '{}' ({}): stations.{}.parameters does not state {}; a wrong one burns the motor", s.name,
                     s.profile.title, s.name, fmt::join(s.profile.not_stated, ", "));
}

namespace {

std::string_view why_not_hoped_for(QuickStop known) {
  switch (known) {
    case QuickStop::Coasts: return "its 605Ah takes the torque";
    case QuickStop::Unknown: return "no manual says what its 605Ah does, or nothing sets it";
    case QuickStop::Absent: return "it has no 605Ah";
    case QuickStop::Brakes: break;
  }
  return "";
}

/// How an axis is stopped whose drives are not known to brake by themselves, and what is then left to its station.
void note_stop(const Machine& machine, const Axis& axis, std::vector<std::string>& out) {
  if (axis.kind != AxisKind::Streamed) return;
  for (const DriveRef& ref : axis.drives) {
    const Station& s = machine.stations[ref.station.value];
    const QuickStop known = quick_stop_of(s.profile, ref.slot);
    if (known == QuickStop::Brakes) continue;
    const double shown = axis.rotary ? units::deg(axis.v_max) : axis.v_max;
    const char* unit = axis.rotary ? "deg" : "mm";
    out.push_back(fmt::format(
        "axis {} ({}): {}; a stop brakes it by its targets and takes the torque when it stands. When the program dies "
        "it stands at its last target until its watchdog ends that; if nothing brakes it then, it goes {:.6g} {} in "
        "every 100 ms at full speed",
        axis.name, s.profile.title, why_not_hoped_for(known), shown * 0.1, unit));
    return;
  }
}

}  // namespace

std::vector<std::string> notes(const Machine& machine) {
  std::vector<std::string> out;
  for (const Axis& axis : machine.axes) note_stop(machine, axis, out);
  if (const std::string lost = lost_emergency_stop(machine); !lost.empty())
    out.push_back("warning: " + lost + ": refused on a bus of steel");
  for (const Station& s : machine.stations)
    if (!s.profile.not_stated.empty()) out.push_back(not_stated(s) + ": refused on a bus of steel");
  for (const Axis& axis : machine.axes) {
    const Station& s = machine.stations[axis.drives.front().station.value];
    if (!s.profile.drive->closed_loop)
      out.push_back(fmt::format("axis {} runs open loop: its following error is not available, lost steps are not seen",
                                axis.name));
  }
  for (auto& each : drive_limit_notes(machine)) out.push_back(std::move(each));
  for (auto& each : channel_notes(machine)) out.push_back(std::move(each));
  // What the loss of the bus costs; recipes::notes() tells it for the speeds of a recipe.
  if (const auto& valve = machine.outputs[static_cast<std::size_t>(Output::Valve)])
    out.push_back(
        fmt::format("a bus that is lost: the valve stays as it is for {} ms (that the station's watchdog then closes "
                    "it is assumed)",
                    machine.stations[valve->station.value].profile.watchdog_ms));
  for (const AxisId id : {machine.x, machine.y}) {
    const Axis& axis = machine.axes[id.value];
    const double watchdog_s = machine.stations[axis.drives.front().station.value].profile.watchdog_ms * 1e-3;
    out.push_back(
        fmt::format("a bus that is lost at full speed of axis {}: {:.0f} mm until the drive's watchdog bites, then "
                    "{:.0f} mm if it brakes with a_max (how it stops is assumed)",
                    axis.name, axis.v_max * watchdog_s, axis.v_max * axis.v_max / (2 * axis.a_max)));
  }
  return out;
}

}  // namespace gantry::config
