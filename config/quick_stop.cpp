#include "config/quick_stop.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::config {
namespace {

constexpr ObjectAddress kOption{0x605A, 0}, kDeceleration{0x6084, 0}, kQuickDeceleration{0x6085, 0};
// Of the axis's a_max: with less the drive's own stop is longer than the one by targets, jerk and all.
constexpr double kLeastOfMax = 0.5;

const StartupRow* asked(const StationProfile& profile, ObjectAddress of_first_slot, int slot) {
  const ObjectAddress address = in_slot(profile, of_first_slot, slot);
  const auto row = std::find_if(profile.startup.begin(), profile.startup.end(),
                                [&](const StartupRow& r) { return r.address == address && !r.declared; });
  return row != profile.startup.end() ? &*row : nullptr;
}

/// Which ramp a value takes is the standard's (IEC 61800-7-201, 605Ah): 6084h, 6085h, or one that nothing here sets.
std::optional<ObjectAddress> ramp_of(std::int64_t option) {
  switch (option) {
    case 1:
    case 5: return kDeceleration;
    case 2:
    case 6: return kQuickDeceleration;
    default: return std::nullopt;
  }
}

}  // namespace

QuickStop quick_stop_of(const StationProfile& profile, int slot) {
  if (!profile.drive || find_object(profile, kOption) == nullptr) return QuickStop::Absent;
  const StartupRow* option = asked(profile, kOption, slot);
  if (option == nullptr || option->value < 0 || option->value > 31) return QuickStop::Unknown;
  const std::uint32_t value = 1u << option->value;
  if ((profile.drive->quick_stop_coasts & value) != 0) return QuickStop::Coasts;
  if ((profile.drive->quick_stop_options & value) == 0) return QuickStop::Unknown;
  if (ramp_of(option->value)) return quick_stop_ramp(profile, slot) ? QuickStop::Brakes : QuickStop::Unknown;
  const bool other_ramp = option->value == 3 || option->value == 7;  // 60C6h, or the current's limit
  return other_ramp ? QuickStop::Unknown : QuickStop::Brakes;
}

std::optional<double> quick_stop_ramp(const StationProfile& profile, int slot) {
  const StartupRow* option = asked(profile, kOption, slot);
  const auto object = option != nullptr ? ramp_of(option->value) : std::nullopt;
  const StartupRow* ramp = object ? asked(profile, *object, slot) : nullptr;
  if (ramp == nullptr || ramp->value <= 0) return std::nullopt;
  return static_cast<double>(ramp->value) * profile.drive->acceleration_counts_s2;
}

std::optional<double> quick_stop_ramp(const Machine& machine, const Axis& axis, const DriveRef& drive) {
  const auto counts = quick_stop_ramp(machine.stations[drive.station.value].profile, drive.slot);
  if (!counts) return std::nullopt;
  return *counts / std::abs(axis.counts_per_unit);
}

QuickStop quick_stop_of(const Machine& machine, const Axis& axis) {
  for (const DriveRef& drive : axis.drives) {
    const StationProfile& profile = machine.stations[drive.station.value].profile;
    if (const QuickStop known = quick_stop_of(profile, drive.slot); known != QuickStop::Brakes) return known;
    if (const auto ramp = quick_stop_ramp(machine, axis, drive); ramp && *ramp < kLeastOfMax * axis.a_max)
      return QuickStop::Weak;
  }
  return QuickStop::Brakes;
}

}  // namespace gantry::config
