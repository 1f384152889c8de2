// What a machine file states of a station against what the program counts on: facts of the profile that go with a value
// of one of its parameters, and two sides of a beam that are to do the same.
#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "config/machine_file.hpp"
#include "config/stated_facts.hpp"

namespace gantry::config {
namespace {

using written::MachineFile;

/// What of two sides may differ: how each of them is built in, and wired.
constexpr std::array<std::string_view, 3> kOwn{"direction", "input_polarity", "brake_mode"};
constexpr std::string_view kInput = "input_", kCurrent = "run_current";
constexpr double kLeastCurrent = 0.01;  // of the most that the drive gives; less is taken for a slip (assumed)

const Parameter* find_parameter(const StationProfile& profile, std::string_view name) {
  const auto at = std::ranges::find(profile.parameters, name, &Parameter::name);
  return at != profile.parameters.end() ? &*at : nullptr;
}
const StartupRow* asked(const StationProfile& profile, const Parameter& p, int slot) {
  const auto at = std::ranges::find(profile.startup, in_slot(profile, p.address, slot), &StartupRow::address);
  return at != profile.startup.end() ? &*at : nullptr;
}
std::string in_units(const Parameter& p, double value) {
  return fmt::format("{:.6g}{}{}", value / p.per_unit, p.unit.empty() ? "" : " ", p.unit);
}

void check_fact(const StationProfile& profile, const Parameter& p, Location location, Mistakes& mistakes) {
  for (int slot = 0; slot < profile.slots; ++slot)
    if (const StartupRow* row = asked(profile, p, slot); row != nullptr && p.value && row->value != *p.value) {
      mistakes.add(
          Fault::Inconsistent,
          fmt::format("the program counts on {} = {} of {} ({}): by another value motion is scaled wrongly, or "
                      "its watch is blind; leave it out, or write a profile of its own for this station",
                      p.name, *p.value, profile.title, p.why),
          location);
      return;
    }
}

/// The input of the probe is not given to it: then nothing is ever latched, whatever is touched.
void check_probe_input(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  const Axis& axis = m.axes[m.probe.axis.value];
  if (axis.drives.empty()) return;
  const DriveRef& ref = axis.drives.front();
  const Station& s = m.stations[ref.station.value];
  if (!s.profile.drive || s.profile.drive->probe_input.parameter.empty()) return;
  const ProbeInput& wanted = s.profile.drive->probe_input;
  const Parameter* p = find_parameter(s.profile, wanted.parameter);
  const StartupRow* row = p != nullptr ? asked(s.profile, *p, ref.slot) : nullptr;
  if (p == nullptr || (row != nullptr && row->value == wanted.value)) return;
  const auto& written = file.stations[ref.station.value];
  const auto setting = std::ranges::find(written.parameters, wanted.parameter, &written::SettingRow::name);
  mistakes.add(
      Fault::Inconsistent,
      fmt::format("the probe latches on axis {}, and this station ({}) latches only with {} = {} ({}): {}; write "
                  "stations.{}.parameters.{}: {}",
                  axis.name, s.profile.title, wanted.parameter, wanted.value, p->why,
                  row != nullptr ? fmt::format("it is to hold {}", row->value) : "nothing sets it", s.name,
                  wanted.parameter, wanted.value),
      setting != written.parameters.end() ? setting->location : written.location);
}

void check_current(const StationProfile& profile, const Parameter& p, Location location, Mistakes& mistakes) {
  const ObjectRow* object = find_object(profile, p.address);
  const double most = object != nullptr && object->max ? static_cast<double>(*object->max) : 0;
  for (int slot = 0; slot < profile.slots; ++slot)
    if (const StartupRow* row = asked(profile, p, slot);
        row != nullptr && (row->value <= 0 || static_cast<double>(row->value) < kLeastCurrent * most)) {
      mistakes.add(Fault::OutOfRange,
                   fmt::format("{} gives no torque worth its name ({} takes up to {}), and an axis that hangs would "
                               "fall; write the current on the motor's name plate",
                               in_units(p, static_cast<double>(row->value)), profile.title, in_units(p, most)),
                   location);
      return;
    }
}

void note_inputs(const Station& s, std::vector<std::string>& out) {
  for (const Parameter& p : s.profile.parameters) {
    if (!p.name.starts_with(kInput) || !p.value || !s.profile.drive) continue;
    const StartupRow* row = asked(s.profile, p, 0);
    if (row == nullptr || row->value == *p.value) continue;
    out.push_back(
        fmt::format("warning: stations.{}.parameters.{} is {}, and the profile counts on {} ({}); check that "
                    "`inputs` and the wiring go with it",
                    s.name, p.name, row->value, *p.value, p.why));
  }
}

void note_sides(const Machine& m, const Axis& axis, std::vector<std::string>& out) {
  const DriveRef &a = axis.drives[0], &b = axis.drives[1];
  const Station &first = m.stations[a.station.value], &second = m.stations[b.station.value];
  if (first.profile.name != second.profile.name) return;
  for (const Parameter& p : first.profile.parameters) {
    if (p.name.starts_with(kInput) || std::ranges::find(kOwn, p.name) != kOwn.end()) continue;
    const StartupRow *one = asked(first.profile, p, a.slot), *other = asked(second.profile, p, b.slot);
    if (one == nullptr && other == nullptr) continue;
    if (one != nullptr && other != nullptr && one->value == other->value) continue;
    const auto shown = [&](const StartupRow* row) {
      return row != nullptr ? in_units(p, static_cast<double>(row->value)) : std::string("not stated");
    };
    out.push_back(
        fmt::format("warning: the sides of axis {} are asked for different {}: {} of '{}', {} of '{}'; a beam "
                    "racks when its sides do not do the same",
                    axis.name, p.name, shown(one), first.name, shown(other), second.name));
  }
}

}  // namespace

void check_parameters(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  for (std::size_t i = 0; i < m.stations.size(); ++i) {
    const StationProfile& profile = m.stations[i].profile;
    for (const auto& setting : file.stations[i].parameters) {
      const Parameter* p = find_parameter(profile, setting.name);
      if (p == nullptr) continue;
      const Location location = setting.values.empty() ? setting.location : setting.values.front().location;
      if (find_stated_fact(setting.name) != nullptr) check_fact(profile, *p, location, mistakes);
      if (setting.name == kCurrent) check_current(profile, *p, location, mistakes);
    }
  }
  check_probe_input(m, file, mistakes);
}

std::vector<std::string> parameter_notes(const Machine& m) {
  std::vector<std::string> out;
  for (const Station& s : m.stations) note_inputs(s, out);
  for (const Axis& axis : m.axes)
    if (axis.drives.size() == 2) note_sides(m, axis, out);
  return out;
}

}  // namespace gantry::config
