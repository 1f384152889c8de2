// One value an axis, in mm or rad (s^-1, ...). Trivially copyable, so that it may cross the RT boundary; use Eigen::Map
// for algebra.
#pragma once
#include <array>

#include "core/id.hpp"

namespace gantry {

using AxisVec = std::array<double, kMaxAxes>;

/// On the straight line between two positions, at `fraction` of its length.
constexpr AxisVec between(const AxisVec& from, const AxisVec& to, double fraction) {
  AxisVec q{};
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = from[i] + (to[i] - from[i]) * fraction;
  return q;
}

}  // namespace gantry
