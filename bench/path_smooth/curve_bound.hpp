// A lower bound of the time from rest to rest on a curve, each axis within its speed and acceleration, computed apart
// from the planner and without jerk: no speed above the one from which acceleration could have come, nor above the one
// that acceleration can still take down.
#pragma once
#include <vector>

#include "bench/path_smooth/smooth_curve.hpp"

namespace gantry::bench {

struct AxisBounds {
  double v = 0, a = 0;
};

/// `dense`: points of the curve at even steps.
double bound_on_curve_s(const std::vector<Point>& dense, const AxisBounds& limits);

}  // namespace gantry::bench
