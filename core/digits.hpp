// A figure in so many digits that is not below, or not above, the value that it stands for.
//   fmt::format("{:.6g} mm", in_digits_up(37.4, 2));   // 38
#pragma once
#include <cmath>

namespace gantry {

namespace detail {
inline double last_digit(double value, int digits) {
  return std::pow(10, std::floor(std::log10(value)) - (digits - 1));
}
}  // namespace detail

/// Of a value > 0.
inline double in_digits_up(double value, int digits) {
  constexpr double kRounding = 1e-9;
  const double digit = detail::last_digit(value, digits);
  return std::ceil(value / digit - kRounding) * digit;
}

/// Of a value > 0.
inline double in_digits_down(double value, int digits) {
  const double digit = detail::last_digit(value, digits);
  return std::floor(value / digit) * digit;
}

}  // namespace gantry
