// What a drive holds of its own limits where the machine file does not state it: as a station was found to hold it,
// beside what its axis needs.
//   for (const auto& d : config::held_limit_doubts(machine, read)) if (d.refuses) ...
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/drive.hpp"
#include "core/id.hpp"

namespace gantry::config {

struct Machine;

/// What a station was found to hold; nothing where it was not read.
using HeldValues = std::function<std::optional<std::int64_t>(StationId, ObjectAddress)>;

struct HeldDoubt {
  std::string text;
  StationId station;
  bool refuses = false;  ///< the axis cannot do what its machine file says; else it merely surprises
};
/// Of values that were read from a station; what the machine file states is compared when it is loaded.
std::vector<HeldDoubt> held_limit_doubts(const Machine& machine, const HeldValues& read);

/// The parameters that neither the profile nor the machine file pins, as rows that may be read; `value` is the default
/// of the manual, or 0.
std::vector<StartupRow> not_pinned(const StationProfile& profile);
/// A row is one of the limits that held_limit_doubts() looks at.
bool is_limit(const StartupRow& row);

}  // namespace gantry::config
