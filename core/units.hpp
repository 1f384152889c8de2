// Units: mm, rad and s inside; text of files and command lines carries its unit ("20 mm/s", "90 deg", "15 ms").
//   auto v = units::parse("20 mm/s", units::Dimension::Speed);   // 20.0, or an Error that names the unit expected
// A bare number where a unit belongs is an error, and so are nan, inf, hex, octal and a unit of another dimension.
#pragma once
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace gantry::units {

enum class Dimension {
  None,                 ///< a plain number; a unit is an error
  Length,               ///< mm
  Angle,                ///< rad
  Time,                 ///< s
  Speed,                ///< mm/s
  Acceleration,         ///< mm/s^2
  Jerk,                 ///< mm/s^3
  AngularSpeed,         ///< rad/s
  AngularAcceleration,  ///< rad/s^2
  AngularJerk,          ///< rad/s^3
  Ratio,                ///< 1: 100 %
};

/// Value in the house's unit of `dimension`. Fault::BadUnit with the accepted units in the text.
Result<double> parse(std::string_view text, Dimension dimension);

/// The unit that messages and printed values use: "mm", "mm/s", "rad" ...; "" for None.
std::string_view name(Dimension dimension);

/// Every way to write a unit of `dimension`, the house's own first; empty for None.
std::vector<std::string_view> symbols(Dimension dimension);

/// An example that a message can show: "20 mm/s".
std::string_view example(Dimension dimension);

constexpr double rad(double deg) { return deg * std::numbers::pi / 180.0; }
constexpr double deg(double rad) { return rad * 180.0 / std::numbers::pi; }

}  // namespace gantry::units
