// A unit to state speeds in, so that the figures of two machines can be compared: time for a fixed chain of dependent
// double arithmetic.
#pragma once
#include <cmath>

namespace gantry::bench {

/// Newton on quartics with coefficients from x in (0, 1): divisions, roots and branches that depend on each other.
__attribute__((noinline)) inline double yard(double x) {
  double sum = 0;
  for (int k = 1; k <= 6; ++k) {
    const double a = x * k, b = 1 - x / k, c = std::sqrt(a + b), d = -0.5 * c;
    double t = 1 + a;
    for (int i = 0; i < 4; ++i) {
      const double f = (((t + a) * t + b) * t + c) * t + d, g = ((4 * t + 3 * a) * t + 2 * b) * t + c;
      const double step = f / g;
      t -= step;
      if (std::abs(step) < 1e-9 * t) break;
    }
    sum += t > x ? std::sqrt(t) : t;
  }
  return sum;
}

}  // namespace gantry::bench
