// Who brakes an axis when it is to stop quickly: its drives, by a quick stop that is known, or the loop by its targets.
//   if (quick_stop_of(machine, axis) == QuickStop::Brakes) ...
#pragma once
#include <cstdint>
#include <optional>

#include "config/drive.hpp"
#include "config/machine.hpp"

namespace gantry::config {

/// What is known of a quick stop, by the profile and by what the machine file asks of it.
enum class QuickStop : std::uint8_t {
  Brakes,   ///< 605Ah holds a value that by the manual stops the motor, and the ramp that it takes is set
  Weak,     ///< the same, but that ramp is far below what the axis brakes with by its targets
  Coasts,   ///< 605Ah holds a value that takes the torque
  Unknown,  ///< no manual says what the value does, or nothing pins it
  Absent,   ///< there is no 605Ah
};

/// Of one axis of a station: never Weak.
QuickStop quick_stop_of(const StationProfile& profile, int slot);
/// The ramp that its 605Ah takes, where something sets it, counts/s^2.
std::optional<double> quick_stop_ramp(const StationProfile& profile, int slot);
/// The same of one drive of an axis, mm or rad/s^2.
std::optional<double> quick_stop_ramp(const Machine& machine, const Axis& axis, const DriveRef& drive);
/// Of all drives of an axis: Brakes only where each of them does. Sides of a beam that stop in two ways would rack it.
QuickStop quick_stop_of(const Machine& machine, const Axis& axis);

}  // namespace gantry::config
