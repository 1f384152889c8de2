// How steadily a bead was dispensed, from where the needle was at each sync while the valve was open.
//   if (const auto speed = speed_of(shots, 20.0, 0.001)) speed->least_mm_s
#pragma once
#include <optional>
#include <span>

#include "sim/world/deposits.hpp"

namespace gantry::sim {

/// Of the shots that make up one bead. Nothing where no time has passed with the valve open, or no speed was asked for.
std::optional<DepositSpeed> speed_of(std::span<const Shot* const> shots, double asked_mm_s, double sync_s);

}  // namespace gantry::sim
