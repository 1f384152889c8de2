// Limits judged by the differences of setpoints: the n-th difference over h^n is a mean of the n-th derivative.
//   Differences judge(recent, limits);   if (!judge.keeps_limits(q)) ...      // tick after tick
// Lives in the loop.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "motion/types.hpp"

namespace gantry::motion {

/// The last three setpoints, oldest first.
using Recent = std::array<AxisVec, 3>;

class Differences {
 public:
  Differences(const Recent& recent, const Limits& limits) noexcept : last_(recent), limits_(limits) {}
  /// The next setpoint is q. False: a limit is broken.
  bool keeps_limits(const AxisVec& q) noexcept {
    constexpr double kUse = 1 + 5e-5;  // rounding of plans
    const double h = limits_.tick_s;
    bool keeps = true;
    for (std::size_t i = 0; i < limits_.axes; ++i) {
      const AxisLimits& l = limits_.axis[i];
      const double x0 = last_[0][i], x1 = last_[1][i], x2 = last_[2][i], x3 = q[i];
      const double rounding = 2.3e-16 * std::max(std::abs(x3), 1.0);
      keeps = keeps && std::abs(x3 - x2) <= kUse * l.v_max * h + 2 * rounding &&
              std::abs(x3 - 2 * x2 + x1) <= kUse * l.a_max * h * h + 4 * rounding &&
              std::abs(x3 - 3 * x2 + 3 * x1 - x0) <= kUse * l.j_max * h * h * h + 8 * rounding;
    }
    last_ = {last_[1], last_[2], q};
    return keeps;
  }

 private:
  Recent last_;
  const Limits& limits_;
};

}  // namespace gantry::motion
