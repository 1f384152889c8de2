#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include "config/bus_notes.hpp"
#include "config/look_alikes.hpp"
#include "config/machine_file.hpp"
#include "config/quick_stop.hpp"

namespace gantry::config {
namespace {

using written::MachineFile;

/// No stepper or servo of this size turns faster (assumed); what is written beyond is another unit or a 0 too many.
constexpr double kMostRevs_s = 200;

void check_stations(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  std::map<std::pair<BusKind, int>, std::string> positions;
  int on_ring = 0;
  for (const Station& s : m.stations) on_ring += s.bus == BusKind::EtherCat;
  for (std::size_t i = 0; i < m.stations.size(); ++i) {
    const Station& s = m.stations[i];
    const Location location = file.stations[i].position.location;
    const auto [other, is_new] = positions.try_emplace({s.bus, s.position}, s.name);
    if (!is_new)
      mistakes.add(Fault::Inconsistent, fmt::format("'{}' stands at {} already", other->second, s.position), location);
    else if (s.bus == BusKind::EtherCat && s.position >= on_ring)
      mistakes.add(Fault::OutOfRange, fmt::format("the ring has {} stations; positions count from 0", on_ring),
                   location);
    else if (s.bus == BusKind::CanOpen && s.position == 0)
      mistakes.add(Fault::OutOfRange, "CANopen node ids are 1 .. 127", location);
    for (std::size_t k = 0; k < i; ++k)
      if (s.alias != 0 && s.alias == m.stations[k].alias && look_alike(s, m.stations[k]))
        mistakes.add(Fault::Inconsistent,
                     fmt::format("'{}' looks like '{}' ({}) and has the same alias, so that nobody sees it when their "
                                 "cables are swapped; give each an alias of its own, and set it on the station",
                                 s.name, m.stations[k].name, s.profile.title),
                     file.stations[i].alias_location);
  }
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
                   row.drives[d].location);
    if (axis.homing && std::find(drive.homing_methods.begin(), drive.homing_methods.end(), axis.homing->method) ==
                           drive.homing_methods.end())
      mistakes.add(Fault::Inconsistent,
                   fmt::format("{} homes by methods {}", station.profile.title, fmt::join(drive.homing_methods, ", ")),
                   row.homing->method.location);
    if (row.following && !drive.closed_loop)
      mistakes.add(
          Fault::Inconsistent,
          fmt::format("{} runs open loop: its position is the command, so there is no following error to watch",
                      station.profile.title),
          row.following->base.location);
    if (row.self_locking && drive.closed_loop)
      mistakes.add(Fault::Inconsistent,
                   fmt::format("{} measures where the axis is, whatever moves it; leave 'self_locking' out",
                               station.profile.title),
                   row.self_locking_location);
  }
  if (watched && axis.kind == AxisKind::Streamed && !row.following)
    mistakes.add(Fault::MissingKey, "'following' is missing here (the window of a closed-loop axis)", row.location);
  if (axis.unit_per_rev > 0 && axis.v_max / axis.unit_per_rev > kMostRevs_s)
    mistakes.add(Fault::OutOfRange,
                 fmt::format("turns the motor at {:.6g} rpm; more than {:.6g} rpm is taken for a slip",
                             60 * axis.v_max / axis.unit_per_rev, 60 * kMostRevs_s),
                 row.v_max.location);
  if (axis.drives.size() == 2 && !row.skew_max.given())
    mistakes.add(Fault::MissingKey, "'skew_max' is missing here (a gantry axis must watch its two sides)",
                 row.location);
  if (axis.drives.size() != 1) return;
  const written::HomingRow none, &homing = row.homing ? *row.homing : none;
  for (const auto* at : {&row.skew_max, &homing.rack_max, &homing.square_max})
    if (at->given()) {
      mistakes.add(Fault::Inconsistent, "one drive has no skew; leave it out, and what else is of two sides",
                   at->location);
      break;
    }
}

/// Each role has an axis of its own; where one has two, nothing else that is told of it would be to the point.
bool check_roles(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  struct Role {
    const char* name;
    std::optional<AxisId> axis;
    Location location;
  };
  const Role roles[] = {{"x", m.x, file.roles.x.location},
                        {"y", m.y, file.roles.y.location},
                        {"z", m.z, file.roles.z.location},
                        {"turn", m.c, file.roles.turn.location},
                        {"lift", m.u, file.roles.lift.location}};
  bool apart = true;
  for (std::size_t i = 0; i < std::size(roles); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      if (!roles[i].axis || roles[i].axis != roles[k].axis) continue;
      apart = false;
      mistakes.add(Fault::Inconsistent,
                   fmt::format("axis {} has the role '{}' already; write another axis, or leave '{}' out where the "
                               "machine has none",
                               m.axes[roles[i].axis->value].name, roles[k].name, roles[i].name),
                   roles[i].location);
    }
  return apart;
}

/// From rest to v_max: in three phases where a_max is reached, else in two.
double rise_s(double v, double a, double j) { return v >= a * a / j ? v / a + a / j : 2 * std::sqrt(v / j); }

constexpr double kLongestRise_s = 10;

/// An axis that hardly starts is a slip of the unit, and every motion of it would take minutes.
void check_rise(const Axis& axis, const written::AxisRow& row, Mistakes& mistakes) {
  const double v = axis.v_max, a = axis.a_max, j = axis.j_max;
  const bool v_is_wrong = axis.unit_per_rev > 0 && v / axis.unit_per_rev > kMostRevs_s;  // and told
  if (v_is_wrong || !(v > 0 && a > 0 && j > 0) || !starts_too_slowly(axis)) return;
  // With v / a of at most half of it, the least jerk reaches no a_max: 2 sqrt(v / j) is the whole of it.
  const bool of_acceleration = v / a > kLongestRise_s / 2;
  mistakes.add(
      Fault::OutOfRange,
      fmt::format("the axis needs {:.3g} s from rest to its v_max; more than {:.6g} s is taken for a slip: write "
                  "at least {}",
                  rise_s(v, a, j), kLongestRise_s,
                  of_acceleration ? in_units(axis, 2 * v / kLongestRise_s, "/s^2")
                                  : in_units(axis, 4 * v / (kLongestRise_s * kLongestRise_s), "/s^3")),
      of_acceleration ? row.a_max.location : row.j_max.location);
}

/// A jerk that comes to a_max in less than that is a slip: no plan could be told from one without a jerk limit.
void check_jerk(const Axis& axis, const written::AxisRow& row, Mistakes& mistakes) {
  constexpr double kLeast_s = 1e-6;
  if (!(axis.a_max > 0 && axis.j_max > 0) || axis.a_max / axis.j_max >= kLeast_s) return;
  mistakes.add(Fault::OutOfRange,
               fmt::format("the axis would come to its a_max in {:.2g} s; less than 1 us is taken for a slip: write at "
                           "most {}",
                           axis.a_max / axis.j_max, in_units(axis, axis.a_max / kLeast_s, "/s^3")),
               row.j_max.location);
}

void check_axes(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  std::map<std::pair<StationId, int>, std::string> taken;
  for (std::size_t i = 0; i < m.axes.size(); ++i) {
    check_axis(m, m.axes[i], file.axes[i], mistakes);
    check_rise(m.axes[i], file.axes[i], mistakes);
    check_jerk(m.axes[i], file.axes[i], mistakes);
    for (std::size_t d = 0; d < m.axes[i].drives.size(); ++d) {
      const DriveRef& ref = m.axes[i].drives[d];
      const auto [other, is_new] = taken.try_emplace({ref.station, ref.slot}, m.axes[i].name);
      if (!is_new)
        mistakes.add(Fault::Inconsistent, fmt::format("axis '{}' has this drive already", other->second),
                     file.axes[i].drives[d].location);
    }
  }
  const auto is_streamed = [&](AxisId id) { return m.axes[id.value].kind == AxisKind::Streamed; };
  for (const auto& [role, name] : {std::pair{m.x, &file.roles.x}, {m.y, &file.roles.y}, {m.z, &file.roles.z}})
    if (!is_streamed(role))
      mistakes.add(Fault::Inconsistent, "an axis that carries the head must be streamed", name->location);
  for (const auto& [role, name] : {std::pair{m.c, &file.roles.turn}, {m.u, &file.roles.lift}})
    if (role && !is_streamed(*role))
      mistakes.add(Fault::Inconsistent,
                   fmt::format("axis {} is positioned: its drive moves by itself, and a job plays targets to the axes "
                               "of its roles; name a streamed axis",
                               m.axes[role->value].name),
                   name->location);
  const auto& z_homing = m.axes[m.z.value].homing;
  for (const AxisId id : {m.x, m.y})
    if (const auto& h = m.axes[id.value].homing; h && z_homing && z_homing->order >= h->order) {
      mistakes.add(Fault::Inconsistent,
                   fmt::format("axis {} moves sideways before {} is up; give {} the lowest order",
                               m.axes[id.value].name, m.axes[m.z.value].name, m.axes[m.z.value].name),
                   file.axes[m.z.value].homing->location);
      break;
    }
  for (std::size_t i = 0; i < file.park.size(); ++i) {
    const Axis& axis = m.axes[m.park[i].first.value];
    const bool has_role = axis.id == m.c || axis.id == m.u;  // then it is told there
    if (axis.kind != AxisKind::Streamed) {
      if (!has_role)
        mistakes.add(
            Fault::Inconsistent,
            fmt::format("axis {} is positioned: its drive moves by itself, and no job takes it anywhere; leave "
                        "it out",
                        axis.name),
            file.park[i].location);
    } else if (m.park[i].second < axis.p_min || m.park[i].second > axis.p_max)
      mistakes.add(Fault::OutOfRange, outside_of(axis), file.park[i].quantity.location);
  }
  const Axis& z = m.axes[m.z.value];
  if (m.safe_z_mm < z.p_min || m.safe_z_mm > z.p_max)
    mistakes.add(Fault::OutOfRange, outside_of(z), file.safe_z_mm.location);
}

void check_sim(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  for (const auto& row : file.sim.axes) {
    const Axis& axis = *find_axis(m, row.name);
    const SimAxis& truth = m.sim.axes[axis.id.value];
    if (truth.neg_limit >= axis.p_min || truth.pos_limit <= axis.p_max)
      mistakes.add(Fault::Inconsistent,
                   fmt::format("axis {} travels from {} to {}, and its simulated limit switches must stand beyond both "
                               "ends; move them outwards, or write a shorter 'travel'",
                               axis.name, in_units(axis, axis.p_min), in_units(axis, axis.p_max)),
                   row.limits.location);
    if (truth.start < truth.neg_limit || truth.start > truth.pos_limit)
      mistakes.add(Fault::OutOfRange, "outside the limit switches", row.start.location);
  }
}

}  // namespace

bool starts_too_slowly(const Axis& axis) {
  const double v = axis.v_max, a = axis.a_max, j = axis.j_max;
  return v > 0 && a > 0 && j > 0 && rise_s(v, a, j) > kLongestRise_s;
}

std::string in_units(const Axis& axis, double value, std::string_view per, int digits) {
  return fmt::format("{:.{}g} {}{}", axis.rotary ? units::deg(value) : value, digits, axis.rotary ? "deg" : "mm", per);
}

std::string outside_of(const Axis& axis) {
  return fmt::format("outside the travel of axis {}, {} .. {}", axis.name, in_units(axis, axis.p_min),
                     in_units(axis, axis.p_max));
}

void check_machine(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  check_stations(m, file, mistakes);
  if (!check_roles(m, file, mistakes)) return;
  const bool cycle_fits = check_timing(m, file, mistakes);
  check_axes(m, file, mistakes);
  check_homing(m, file, mistakes);
  if (cycle_fits) check_windows(m, file, mistakes);
  check_head(m, file, mistakes);
  check_sim(m, file, mistakes);
  check_drive_limits(m, file, mistakes);
  check_parameters(m, file, mistakes);
}

std::vector<std::string> assumptions(const Machine& machine) {
  std::vector<std::string> out;
  std::set<std::string> told;
  for (const Station& s : machine.stations) {
    if (!told.insert(s.profile.name).second) continue;
    if (s.profile.identity.assumed)
      out.push_back(fmt::format(
          "{}: identity {:08X}:{:08X} is assumed; a station that answers otherwise is refused until `gantry commission "
          "NAME --accept` has taken it",
          s.profile.title, s.profile.identity.vendor, s.profile.identity.product));
    std::string late;
    for (const Parameter& p : s.profile.parameters)
      if (p.assumed && p.acts == ActsAt::PowerUp) late += (late.empty() ? "" : ", ") + p.name;
    if (!late.empty())
      out.push_back(
          fmt::format("{}: of these, where they are or that they act at power-up: {}", s.profile.title, late));
    for (const std::string& sentence : s.profile.assumptions)
      out.push_back(fmt::format("{}: {}", s.profile.title, sentence));
  }
  return out;
}

namespace {

std::string_view why_not_hoped_for(QuickStop known) {
  switch (known) {
    case QuickStop::Coasts: return "its 605Ah takes the torque";
    case QuickStop::Weak: return "the ramp of its quick stop is less than half of a_max";
    case QuickStop::Unknown:
      return "no manual says what its 605Ah does, or nothing sets it, or not the ramp that it takes";
    case QuickStop::Absent: return "it has no 605Ah";
    case QuickStop::Brakes: break;
  }
  return "";
}

/// Why the probe costs a drive its emergency stop input, as long as its station does not say where that is wired.
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

/// An axis that would home although its profile does not say which bits of 60FDh its limit switches are.
std::string limits_not_shown(const Machine& machine) {
  for (const Axis& axis : machine.axes) {
    if (axis.kind != AxisKind::Streamed || !axis.homing || axis.homing->limits_unseen) continue;
    for (const DriveRef& drive : axis.drives) {
      const Station& s = machine.stations[drive.station.value];
      if (!s.profile.drive || (s.profile.drive->input_neg_limit >= 0 && s.profile.drive->input_pos_limit >= 0))
        continue;
      return fmt::format(
          "axis {}: which bits of 60FDh the limit switches of station '{}' ({}) are is not stated, so that homing "
          "cannot "
          "watch them; write stations.{}.inputs, or `homing: {{limits_unseen: true}}` of this axis, which leaves them "
          "to "
          "the drive alone",
          axis.name, s.name, s.profile.title, s.name);
    }
  }
  return "";
}

std::string not_stated(const Station& s) {
  return fmt::format("station '{}' ({}): stations.{}.parameters does not state {}; a wrong one burns the motor", s.name,
                     s.profile.title, s.name, fmt::join(s.profile.not_stated, ", "));
}

/// How an axis is stopped whose drives are not known to brake by themselves, and what is then left to its station.
void note_stop(const Machine& machine, const Axis& axis, std::vector<std::string>& out) {
  const QuickStop known = quick_stop_of(machine, axis);
  if (axis.kind != AxisKind::Streamed || axis.drives.empty() || known == QuickStop::Brakes) return;
  for (const DriveRef& ref : axis.drives) {
    const Station& s = machine.stations[ref.station.value];
    const bool other = known != QuickStop::Weak && quick_stop_of(s.profile, ref.slot) != known;  // side of the beam
    if (other) continue;
    out.push_back(fmt::format(
        "axis {} ({}): {}; a stop brakes it by its targets and takes the torque when it stands. When the program dies "
        "it stands at its last target until its watchdog ends that; if nothing brakes it then, it goes {} in "
        "every 100 ms at full speed",
        axis.name, s.profile.title, why_not_hoped_for(known), in_units(axis, axis.v_max * 0.1)));
    return;
  }
}

}  // namespace

bool is_braked(const Machine& machine, const Axis& axis, const DriveRef& drive) {
  if (machine.brake && machine.brake->axis == axis.id) return true;
  const auto& rows = machine.stations[drive.station.value].profile.startup;
  return std::any_of(rows.begin(), rows.end(),  // a drive that works a brake says so in its parameters
                     [](const StartupRow& row) { return row.name == "brake_mode" && row.value != 0; });
}

std::vector<std::string> wanted_on_steel(const Machine& machine) {
  std::vector<std::string> out;
  for (const Station& s : machine.stations)
    if (!s.profile.not_stated.empty()) out.push_back(not_stated(s));
  if (std::string lost = lost_emergency_stop(machine); !lost.empty()) out.push_back(std::move(lost));
  if (std::string unseen = limits_not_shown(machine); !unseen.empty()) out.push_back(std::move(unseen));
  return out;
}

std::vector<std::string> notes(const Machine& machine) {
  std::vector<std::string> out;
  for (const auto& wanted : wanted_on_steel(machine)) out.push_back(fmt::format("warning: {}{}", wanted, kOnSteel));
  for (const Axis& axis : machine.axes) {
    const Station& s = machine.stations[axis.drives.front().station.value];
    if (!s.profile.drive->closed_loop)
      out.push_back(fmt::format(
          "axis {} runs open loop: its following error is not available, lost steps are not seen; {}", axis.name,
          axis.self_locking
              ? "without torque it keeps its reference, because `self_locking` says that nothing moves it then"
          : is_braked(machine, axis, axis.drives.front())
              ? "without torque it keeps its reference, because its brake holds it"
              : "without torque it loses its reference, because nothing shows what moves it then "
                "(`self_locking: true` where it stays by itself)"));
  }
  for (auto& each : look_alikes(machine)) out.push_back("warning: " + std::move(each));
  for (auto& each : homing_notes(machine)) out.push_back(std::move(each));
  for (auto& each : window_notes(machine)) out.push_back(std::move(each));
  for (auto& each : head_notes(machine)) out.push_back(std::move(each));
  for (auto& each : parameter_notes(machine)) out.push_back(std::move(each));
  for (auto& each : drive_limit_notes(machine)) out.push_back(std::move(each));
  for (auto& each : channel_notes(machine)) out.push_back(std::move(each));
  return out;
}

std::vector<std::string> bus_notes(const Machine& machine) {
  std::vector<std::string> out;
  for (const Axis& axis : machine.axes) note_stop(machine, axis, out);
  if (const auto& valve = machine.outputs[static_cast<std::size_t>(Output::Valve)])
    out.push_back(
        fmt::format("a bus that is lost: the valve stays as it is for {} ms (that the station's watchdog then closes "
                    "it is assumed)",
                    machine.stations[valve->station.value].profile.watchdog_ms));
  for (const AxisId id : {machine.x, machine.y}) {
    const Axis& axis = machine.axes[id.value];
    const double watchdog_s = machine.stations[axis.drives.front().station.value].profile.watchdog_ms * 1e-3;
    out.push_back(fmt::format(
        "a bus that is lost at full speed of axis {}: a drive that stands at its last target stops there; one "
        "that goes on at its speed does {:.0f} mm until its watchdog bites, then {:.0f} mm if it brakes with "
        "a_max (no manual says which)",
        axis.name, axis.v_max * watchdog_s, axis.v_max * axis.v_max / (2 * axis.a_max)));
  }
  return out;
}

}  // namespace gantry::config
