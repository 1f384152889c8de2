// Power series, cut off behind the third power: how whoever looks at a plan differentiates it, apart from the formulas
// of the planner.
#pragma once
#include <array>
#include <cstddef>

namespace gantry::motion {

/// x0 + x1 e + x2 e^2 + x3 e^3.
using Series = std::array<double, 4>;

inline Series times(const Series& a, const Series& b) {
  Series out{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; i + j < 4; ++j) out[i + j] += a[i] * b[j];
  return out;
}

/// c(0) + c(1) x + ... + c(degree) x^degree.
template <class Coefficients>
Series polynomial(const Coefficients& c, std::size_t degree, const Series& x) {
  Series out{c(degree), 0, 0, 0};
  for (std::size_t k = degree; k-- > 0;) {
    out = times(out, x);
    out[0] += c(k);
  }
  return out;
}

}  // namespace gantry::motion
