// The start-up rows by which a drive homes by itself (CiA 402-2, 13), with the names by which a machine file may
// declare that a station does not have one of them. Their values are the axis' (devices/profiles/homing_objects.hpp).
#pragma once
#include <array>
#include <string_view>

#include "config/drive.hpp"

namespace gantry::config {

struct HomingRow {
  std::string_view name;
  ObjectAddress address;  ///< of the first axis
  ObjectType type;        ///< where the profile has no row of its own
  std::string_view why;
};
inline constexpr std::array<HomingRow, 5> kHomingRows{{
    {"homing_method", {0x6098, 0}, ObjectType::I8, "homing method"},
    {"homing_fast", {0x6099, 1}, ObjectType::U32, "speed towards the switch"},
    {"homing_slow", {0x6099, 2}, ObjectType::U32, "speed at the edge"},
    {"homing_acceleration", {0x609A, 0}, ObjectType::U32, "acceleration"},
    {"home_offset", {0x607C, 0}, ObjectType::I32, "the home edge has the counts 0"},
}};

}  // namespace gantry::config
