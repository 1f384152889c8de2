// The planner's inner problem without units: time in a/j, with a and j the larger of the two bounds each, so that no
// bound exceeds 1. With T = a/j: v* = v / (a T), p* = p / (a T^2). Tolerances are relative to these.
#pragma once
#include <cstdint>

namespace gantry::motion::scaled {

/// Speed and acceleration at both ends.
struct Ends {
  double v0 = 0, a0 = 0, vf = 0, af = 0;
};

/// Bounds as magnitudes, upwards and downwards. 0 < a, j <= 1 each.
struct Box {
  double v_up = 0, v_down = 0;  ///< -v_down <= v <= v_up
  double a_up = 1, a_down = 1;
  double j_up = 1, j_down = 1;
};

/// The same problem looked at with p, v, a turned round.
[[nodiscard]] constexpr Ends mirrored(const Ends& e) noexcept { return {-e.v0, -e.a0, -e.vf, -e.af}; }
[[nodiscard]] constexpr Box mirrored(const Box& b) noexcept {
  return {b.v_down, b.v_up, b.a_down, b.a_up, b.j_down, b.j_up};
}

/// Durations and jerks of seven phases.
struct Shape {
  double t[7] = {};
  double j[7] = {};
  [[nodiscard]] double duration() const noexcept { return t[0] + t[1] + t[2] + t[3] + t[4] + t[5] + t[6]; }
};

}  // namespace gantry::motion::scaled
