#include "devices/profiles/homing_objects.hpp"

#include <cmath>
#include <fmt/format.h>

#include "devices/wire/cia402.hpp"

namespace gantry::devices {

Result<std::vector<config::StartupRow>> homing_objects(const config::StationProfile& profile, int slot,
                                                       const config::Axis& axis) {
  namespace cia = wire::cia402;
  if (!axis.homing || !profile.drive)
    return fail(Fault::NotReferenced, fmt::format("axis {} has no homing", axis.name));
  const config::Homing& homing = *axis.homing;
  const config::DriveFacts& facts = *profile.drive;
  const double counts = std::abs(axis.counts_per_unit);

  struct Wanted {
    config::ObjectAddress first_slot;
    config::ObjectType type;  ///< where the profile has no row of its own
    double value;
    const char* why;
  };
  std::vector<config::StartupRow> rows;
  for (const auto& w : {
           Wanted{{cia::kHomingMethod, 0}, config::ObjectType::I8, double(homing.method), "homing method"},
           Wanted{{cia::kHomingSpeeds, 1},
                  config::ObjectType::U32,
                  homing.fast * counts / facts.velocity_counts_s,
                  "speed towards the switch"},
           Wanted{{cia::kHomingSpeeds, 2},
                  config::ObjectType::U32,
                  homing.slow * counts / facts.velocity_counts_s,
                  "speed at the edge"},
           Wanted{{cia::kHomingAcceleration, 0},
                  config::ObjectType::U32,
                  homing.acceleration * counts / facts.acceleration_counts_s2,
                  "acceleration"},
           Wanted{{cia::kHomeOffset, 0}, config::ObjectType::I32, 0, "the home edge has the counts 0"},
       }) {
    const auto* row = config::find_object(profile, w.first_slot);
    const std::int64_t value = std::llround(w.value);
    if (row != nullptr && ((row->min && value < *row->min) || (row->max && value > *row->max)))
      return fail(Fault::OutOfRange,
                  fmt::format("homing of axis {}: {} for its {} is outside what {} takes in {:04X}h:{}", axis.name,
                              value, w.why, profile.title, w.first_slot.index, w.first_slot.sub));
    rows.push_back({config::in_slot(profile, w.first_slot, slot), row != nullptr ? row->type : w.type, value, w.why});
  }
  return rows;
}

}  // namespace gantry::devices
