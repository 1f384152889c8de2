// How long an axis takes to change its speed.
//   change_duration(26, 3000, 50000)   // s, from 90 to 64 mm/s
#pragma once
#include <cmath>

namespace gantry {

/// By d >= 0, without acceleration at either end: 2 sqrt(d/j) where the bound a is not reached (d <= a^2/j), else
/// d/a + a/j; symmetric about its middle.
[[nodiscard]] inline double change_duration(double d, double a, double j) noexcept {
  return d <= a * a / j ? 2 * std::sqrt(d / j) : d / a + a / j;
}

}  // namespace gantry
