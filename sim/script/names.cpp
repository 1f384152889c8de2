#include "sim/script/names.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/near_word.hpp"

namespace gantry::sim {

using config::At;
using config::Input;

namespace {

const config::Station* find_station(const config::Machine& machine, StationId id) {
  const auto at =
      std::find_if(machine.stations.begin(), machine.stations.end(), [&](const auto& s) { return s.id == id; });
  return at == machine.stations.end() ? nullptr : &*at;
}
bool on_the_line(const config::Machine& machine, StationId id) {
  const config::Station* station = find_station(machine, id);
  return station != nullptr && station->bus == config::BusKind::EtherCat;
}

std::string written(config::ObjectAddress a) { return fmt::format("0x{:04X}:{}", a.index, a.sub); }

}  // namespace

void Names::unknown(std::string_view what, const At<std::string>& name, const std::vector<std::string_view>& known) {
  mistakes_.add(Fault::UnknownReference,
                fmt::format("the machine has no {} '{}'; {}", what, name.value, did_you_mean(name.value, known)),
                name.location);
}

StationId Names::station(const At<std::string>& name) {
  if (!name.given()) return {};
  std::vector<std::string_view> known;
  for (const config::Station& s : machine_.stations) {
    if (s.name == name.value && s.bus == config::BusKind::EtherCat) return s.id;
    if (s.name == name.value) {
      mistakes_.add(Fault::UnknownReference,
                    fmt::format("station '{}' is not on the EtherCAT line, and scripts reach no other bus", s.name),
                    name.location);
      return {};
    }
    known.push_back(s.name);
  }
  unknown("station", name, known);
  return {};
}

AxisId Names::axis(const At<std::string>& name) {
  if (!name.given()) return {};
  std::vector<std::string_view> known;
  for (const config::Axis& axis : machine_.axes) {
    known.push_back(axis.name);
    if (axis.name != name.value) continue;
    const bool reached =
        !axis.drives.empty() && std::all_of(axis.drives.begin(), axis.drives.end(),
                                            [&](const auto& d) { return on_the_line(machine_, d.station); });
    if (!reached)
      mistakes_.add(Fault::UnknownReference,
                    fmt::format("axis '{}' has no drive on the EtherCAT line, and scripts reach no other", axis.name),
                    name.location);
    return axis.id;
  }
  unknown("axis", name, known);
  return kNoAxis;
}

int Names::drive(AxisId axis, const At<int>& number) {
  if (!number.given() || axis.value >= machine_.axes.size()) return 0;
  const config::Axis& a = machine_.axes[axis.value];
  if (number.value < static_cast<int>(a.drives.size())) return number.value;
  mistakes_.add(
      Fault::UnknownReference,
      fmt::format("axis '{}' has no drive {}; it has {}, counted from 0", a.name, number.value, a.drives.size()),
      number.location);
  return 0;
}

unsigned Names::input(const At<std::string>& name) {
  if (!name.given()) return 0;
  std::vector<std::string_view> known;
  const auto inputs = config::input_bits(machine_);
  for (const config::WordBit& input : inputs) {
    if (input.name == name.value) return input.bit;
    known.push_back(input.name);
  }
  unknown("input", name, known);
  return 0;
}

unsigned Names::button(const At<std::string>& name) {
  const unsigned bit = input(name);
  if (!name.given() || bit >= config::kInputs) return bit;
  const auto which = static_cast<Input>(bit);
  const bool pressed = which == Input::Start || which == Input::Stop || which == Input::Reset || which == Input::Hold;
  if (!pressed && config::name(which) == name.value)
    mistakes_.add(Fault::BadValue, fmt::format("'{}' is no button; write do: set_input", name.value), name.location);
  return bit;
}

config::ObjectAddress Names::object(StationId id, const At<config::ObjectAddress>& address) {
  const config::Station* station = find_station(machine_, id);
  if (!address.given() || station == nullptr) return address.value;
  const config::StationProfile& profile = station->profile;
  for (int slot = 0; slot < std::max(1, profile.slots); ++slot)
    if (config::find_object(profile, config::first_slot(profile, address.value, slot)) != nullptr) return address.value;
  std::vector<std::string> rows;
  for (const config::ObjectRow& row : profile.objects) rows.push_back(written(row.address));
  const std::string asked = written(address.value);
  mistakes_.add(Fault::UnknownReference,
                fmt::format("station '{}' ({}) has no object {}; {}", station->name, profile.title, asked,
                            did_you_mean(asked, {rows.begin(), rows.end()})),
                address.location);
  return address.value;
}

}  // namespace gantry::sim
