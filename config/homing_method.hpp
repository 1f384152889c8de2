// What a homing method of CiA 402 (6098h) looks for, and which way (IEC 61800-7-201, 10.4). Directions and limits are
// those of the drive's own counter: on a drive that is inverted the axis goes the other way.
//   homing_method(18).toward                 // +1: up the counter, to the positive limit
//   homing_method(mirrored(18)).toward       // -1
// Values only: no allocation, no exception, so that the RT side may use it.
#pragma once
#include <array>
#include <cstdint>

namespace gantry::config {

enum class HomingSwitch : std::uint8_t {
  None,  ///< homes where it stands, or at the next index pulse
  NegativeLimit,
  PositiveLimit,
  Home,
};

struct HomingMethod {
  HomingSwitch looks_for = HomingSwitch::None;
  HomingSwitch turns_at = HomingSwitch::None;  ///< a limit that it may meet on the way
  int toward = 0;                              ///< from where its switch is open: +1, -1; 0: nowhere
  bool index_pulse = false;                    ///< home is the next index pulse and not the switch's edge
};

namespace detail {
struct MethodRow {
  int first, last;
  HomingMethod method;
};
// 1 and 2 look for a limit, 3 to 6 for the home switch from the side where it stands, 7 to 14 for the home switch with
// a limit to turn round at, all with the index pulse; 17 to 30 are the same without it.
inline constexpr int kWithoutPulse = 16;
inline constexpr std::array kMethods{
    MethodRow{1, 1, {HomingSwitch::NegativeLimit, HomingSwitch::NegativeLimit, -1}},
    MethodRow{2, 2, {HomingSwitch::PositiveLimit, HomingSwitch::PositiveLimit, +1}},
    MethodRow{3, 4, {HomingSwitch::Home, HomingSwitch::None, +1}},
    MethodRow{5, 6, {HomingSwitch::Home, HomingSwitch::None, -1}},
    MethodRow{7, 10, {HomingSwitch::Home, HomingSwitch::PositiveLimit, +1}},
    MethodRow{11, 14, {HomingSwitch::Home, HomingSwitch::NegativeLimit, -1}},
};
}  // namespace detail

constexpr HomingMethod homing_method(int number) noexcept {
  if (number == 33 || number == 34) return {.index_pulse = true};
  const bool pulse = number <= detail::kWithoutPulse;
  const int row_number = pulse ? number : number - detail::kWithoutPulse;
  for (const detail::MethodRow& row : detail::kMethods)
    if (row_number >= row.first && row_number <= row.last) {
      HomingMethod method = row.method;
      method.index_pulse = pulse;
      return method;
    }
  return {};
}

/// The method that does the same the other way round; 0: there is none.
constexpr int mirrored(int number) noexcept {
  const int base = number > detail::kWithoutPulse ? number - detail::kWithoutPulse : number;
  const int other = base == 1 || base == 2    ? 3 - base
                    : base >= 3 && base <= 6  ? (base <= 4 ? base + 2 : base - 2)
                    : base >= 7 && base <= 14 ? (base <= 10 ? base + 4 : base - 4)
                                              : 0;
  return other == 0 ? 0 : other + number - base;
}

}  // namespace gantry::config
