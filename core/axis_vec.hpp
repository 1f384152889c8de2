// One value an axis, in mm or rad (s^-1, ...). Trivially copyable, so that it may cross the RT boundary; use Eigen::Map
// for algebra.
#pragma once
#include <array>

#include "core/id.hpp"

namespace gantry {

using AxisVec = std::array<double, kMaxAxes>;

}  // namespace gantry
