#include "devices/profiles/homing_objects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "config/homing_rows.hpp"

namespace gantry::devices {

Result<std::vector<config::StartupRow>> homing_objects(const config::StationProfile& profile, int slot,
                                                       const config::Axis& axis) {
  if (!axis.homing || !profile.drive)
    return fail(Fault::NotReferenced, fmt::format("axis {} has no homing", axis.name));
  const config::Homing& homing = *axis.homing;
  const config::DriveFacts& facts = *profile.drive;
  const double counts = std::abs(axis.counts_per_unit);

  const std::array<double, config::kHomingRows.size()> values{
      double(homing.method), homing.fast * counts / facts.velocity_counts_s,
      homing.slow * counts / facts.velocity_counts_s, homing.acceleration * counts / facts.acceleration_counts_s2, 0};
  std::vector<config::StartupRow> rows;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const config::HomingRow& wanted = config::kHomingRows[i];
    const auto* row = config::find_object(profile, wanted.address);
    const std::int64_t value = std::llround(values[i]);
    if (row != nullptr && ((row->min && value < *row->min) || (row->max && value > *row->max)))
      return fail(Fault::OutOfRange,
                  fmt::format("homing of axis {}: {} for its {} is outside what {} takes in {:04X}h:{}", axis.name,
                              value, wanted.why, profile.title, wanted.address.index, wanted.address.sub));
    rows.push_back({.address = config::in_slot(profile, wanted.address, slot),
                    .type = row != nullptr ? row->type : wanted.type,
                    .value = value,
                    .why = std::string(wanted.why),
                    .name = std::string(wanted.name),
                    .declared = std::ranges::count(profile.declared, wanted.name) > 0});
  }
  return rows;
}

}  // namespace gantry::devices
