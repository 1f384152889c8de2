// How steadily a bead was dispensed, from where the needle was at each sync while the valve was open.
//   if (const auto speed = speed_of(shots, {.mm_s = 20}, 0.001)) speed->least_mm_s
#pragma once
#include <optional>
#include <span>

#include "core/steady_speed.hpp"
#include "sim/world/deposits.hpp"

namespace gantry::sim {

/// Of the shots that make up one bead. Nothing where no time has passed with the valve open, or no speed was asked for.
/// What `within_tolerance`, `held_mm_s` and `sag` say is taken over so long a time that counts of the motors do not
/// show.
std::optional<DepositSpeed> speed_of(std::span<const Shot* const> shots, AskedSpeed asked, double sync_s);

}  // namespace gantry::sim
