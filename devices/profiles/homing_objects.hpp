// The objects of a drive's homing mode, in the vendor's units: written by SDO before HomingRun starts it. This and
// AxisScale are where mm and rad end.
#pragma once
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::devices {

/// Rows for 6098h, 6099h:1, :2, 609Ah and 607Ch (0: the home edge has the counts 0), addresses as on the wire.
/// Fault::NotReferenced when the axis has no homing, Fault::OutOfRange when the drive does not take a value.
Result<std::vector<config::StartupRow>> homing_objects(const config::StationProfile& profile, int slot,
                                                       const config::Axis& axis);

}  // namespace gantry::devices
