// Strong ids of the house. An AxisId is not a StationId: one STD402EC is one station with two axes.
#pragma once
#include <compare>
#include <cstdint>

namespace gantry {

/// Index of a machine axis, 0 .. kMaxAxes-1, in the order of the machine file. Indexes an AxisVec.
struct AxisId {
  std::uint8_t value = 0;
  constexpr auto operator<=>(const AxisId&) const = default;
};

/// Index of a station (a bus node) in the order of the machine file.
struct StationId {
  std::uint16_t value = 0;
  constexpr auto operator<=>(const StationId&) const = default;
};

/// Drive increments as they stand in 6064h and 607Ah. Only AxisScale turns mm or rad into counts.
struct Counts {
  std::int64_t value = 0;
  constexpr auto operator<=>(const Counts&) const = default;
};

/// Number of a bus cycle, counted from the first cycle of the loop. The RT clock's unit.
using CycleIndex = std::int64_t;

inline constexpr std::size_t kMaxAxes = 16;
inline constexpr AxisId kNoAxis{0xFF};

}  // namespace gantry
