// Alterations of a machine for tests that change one side only: what stands on the bus, or what the controller reads.
//   holds(machine, "cu", {0x20F2, 0}, 8000);   object(machine, "x", {0x2190, 1}).writable = false;
#pragma once
#include <algorithm>
#include <cstdint>
#include <string_view>

#include "config/machine.hpp"

namespace gantry::test {

inline config::Station& station(config::Machine& machine, std::string_view name) {
  return *std::ranges::find(machine.stations, name, &config::Station::name);
}
inline config::ObjectRow& object(config::StationProfile& profile, std::uint16_t index, std::uint8_t sub = 0) {
  return *std::ranges::find(profile.objects, config::ObjectAddress{index, sub}, &config::ObjectRow::address);
}
inline config::ObjectRow& object(config::Machine& machine, std::string_view name, config::ObjectAddress address) {
  return object(station(machine, name).profile, address.index, address.sub);
}
inline void remove_object(config::StationProfile& profile, std::uint16_t index) {
  std::erase_if(profile.objects, [&](const config::ObjectRow& row) { return row.address.index == index; });
}
/// What the virtual drive holds when its supply comes, whatever was commissioned.
inline void holds(config::Machine& machine, std::string_view name, config::ObjectAddress address, std::int64_t value) {
  auto& profile = station(machine, name).profile;
  std::erase_if(profile.startup, [&](const auto& row) { return row.address == address; });
  object(machine, name, address).initial = value;
}

}  // namespace gantry::test
