// The homing methods of CiA 402 that need no index pulse (17 to 30 and 35), as lists of what the motor does until which
// switch changes. Figures of IEC 61800-7-201 (10.4); the AMD530B manual tells the same in words (9.1).
//   const HomingMethod* m = homing_method(19);   // nullptr: this method is not modelled
//   m->start_list(inputs)                        // which list, by the switches where it starts
// Directions and limits are those of the drive's own counter.
#pragma once
#include <cstdint>
#include <span>

namespace gantry::sim {

/// Run in a direction until a switch (MotorInput) closes or opens.
struct HomingPhase {
  std::int8_t direction = 0;  ///< +1, -1
  bool fast = false;          ///< 6099h:1, else :2
  std::uint32_t input = 0;
  bool until_closed = false;
};

using HomingList = std::span<const HomingPhase>;

struct HomingMethod {
  std::int8_t number = 0;
  std::uint32_t reference = 0;  ///< the switch that it looks for; 0: homes where it stands
  HomingList off, on;           ///< where that switch is open, closed
  HomingList bounced;           ///< after the limit ahead of the search; empty: that limit is an error
  std::uint32_t bounce = 0;     ///< that limit

  /// The list to begin with, by the switches that are closed.
  [[nodiscard]] HomingList start_list(std::uint32_t inputs) const noexcept;
};

/// nullptr where the method is not modelled.
const HomingMethod* homing_method(int number) noexcept;

}  // namespace gantry::sim
