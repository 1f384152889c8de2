// Integral over 0..1 by Gauss-Legendre with five points: exact to degree 9.
//   const double length = integral([&](double u) { return rate(u); });
#pragma once
#include <array>
#include <cstddef>

namespace gantry::motion {

template <class F>
[[nodiscard]] double integral(F&& f) {
  constexpr std::array<double, 5> kAt{0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155,
                                      0.95308992296933200};
  constexpr std::array<double, 5> kWeight{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                          0.23931433524968324, 0.11846344252809454};
  double sum = 0;
  for (std::size_t k = 0; k < kAt.size(); ++k) sum += kWeight[k] * f(kAt[k]);
  return sum;
}

}  // namespace gantry::motion
