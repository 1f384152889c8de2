// A bead to be tried: through these points, with a valve that is told ahead.
#pragma once
#include <utility>
#include <vector>

#include "motion/path/bead.hpp"

namespace gantry::motion::test {

inline BeadSpec spec_of(std::vector<AxisVec> points, double speed, double tolerance) {
  BeadSpec s;
  s.points = std::move(points);
  s.speed_mm_s = speed;
  s.corner_tolerance_mm = tolerance;
  s.valve = 1;
  s.open_lead_s = 0.012;
  s.close_lead_s = 0.007;
  return s;
}

inline AxisVec at(double x, double y) { return {x, y, -50, 0, 12}; }

}  // namespace gantry::motion::test
