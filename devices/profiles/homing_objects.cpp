#include "devices/profiles/homing_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string_view>

#include "devices/profiles/slots.hpp"
#include "devices/wire/cia402.hpp"

namespace gantry::devices {
namespace {

namespace cia = wire::cia402;
using config::ObjectAddress;
using config::ObjectType;

/// Vendor's unit of a speed or acceleration: value = counts per second (^2) * per_count, or revolutions * per_rev.
struct VendorUnit {
  std::string_view name;
  double per_count, per_rev;
};
constexpr std::array kUnits{
    VendorUnit{"P/S", 1, 0},    VendorUnit{"P/S^2", 1, 0}, VendorUnit{"rpm", 0, 60},
    VendorUnit{"rpm/s", 0, 60}, VendorUnit{"rps/s", 0, 1}, VendorUnit{"0.1 rps/s", 0, 10},
};

Result<std::int64_t> in_vendor_unit(const config::StationProfile& profile, ObjectAddress address,
                                    const config::Axis& axis, double value) {
  const auto row =
      std::find_if(profile.objects.begin(), profile.objects.end(), [&](const auto& o) { return o.address == address; });
  if (row == profile.objects.end())
    return fail(Fault::Inconsistent, fmt::format("profile '{}' has no object {:04X}h:{}, which homing needs",
                                                 profile.name, address.index, address.sub));
  const auto unit = std::find_if(kUnits.begin(), kUnits.end(), [&](const auto& u) { return u.name == row->unit; });
  if (unit == kUnits.end())
    return fail(Fault::BadUnit, fmt::format("profile '{}': unit '{}' of {:04X}h:{} is not known", profile.name,
                                            row->unit, address.index, address.sub));
  const double counts = value * std::abs(axis.counts_per_unit), revs = value / std::abs(axis.unit_per_rev);
  const std::int64_t vendor = std::llround(unit->per_count != 0 ? counts * unit->per_count : revs * unit->per_rev);
  if ((row->min && vendor < *row->min) || (row->max && vendor > *row->max))
    return fail(Fault::OutOfRange,
                fmt::format("homing of axis {}: {} {} is outside what {} takes in {:04X}h:{}", axis.name, vendor,
                            row->unit, profile.title, address.index, address.sub));
  return vendor;
}

}  // namespace

Result<std::vector<config::StartupRow>> homing_objects(const config::StationProfile& profile, int slot,
                                                       const config::Axis& axis) {
  if (!axis.homing) return fail(Fault::NotReferenced, fmt::format("axis {} has no homing", axis.name));
  const config::Homing& homing = *axis.homing;
  std::vector<config::StartupRow> rows;
  const auto add = [&](ObjectAddress first, ObjectType type, std::int64_t value, const char* why) {
    rows.push_back({at_slot(profile, first, slot), type, value, false, why});
  };
  add({cia::kHomingMethod, 0}, ObjectType::I8, homing.method, "homing method");
  struct Speed {
    ObjectAddress address;
    double value;
    const char* why;
  };
  for (const auto& s : {Speed{{cia::kHomingSpeeds, 1}, homing.fast, "speed towards the switch"},
                        Speed{{cia::kHomingSpeeds, 2}, homing.slow, "speed at the edge"},
                        Speed{{cia::kHomingAcceleration, 0}, homing.acceleration, "acceleration"}}) {
    const auto value = in_vendor_unit(profile, s.address, axis, s.value);
    if (!value) return tl::unexpected(value.error());
    add(s.address, ObjectType::U32, *value, s.why);
  }
  add({cia::kHomeOffset, 0}, ObjectType::I32, 0, "the home edge has the counts 0");
  return rows;
}

}  // namespace gantry::devices
