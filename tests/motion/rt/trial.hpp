// One random block, disturbed at random instants, judged from its setpoints alone.
//   Verdict v = trial(seed);   if (!v.wrong.empty()) ...
// The judge shares nothing with the interpolator: limits by differences, the path by the distance to the undisturbed
// run's own positions, stops on lines against the textbook's S-curve.
#pragma once
#include <cstdint>
#include <string>

namespace gantry::motion::test {

struct Verdict {
  std::string wrong;           ///< empty: all is well
  double v = 0, a = 0, j = 0;  ///< largest shares of an axis limit
  double off_mm = 0;           ///< farthest from the undisturbed path
  double stop_share = 0;       ///< longest stop on a line, of the ideal one
  double stop_s = 0;           ///< longest stop anywhere
  std::size_t stops = 0, line_stops = 0, changes = 0, ticks = 0;
  double worst_tick_us = 0;
};

Verdict trial(std::uint64_t seed);

}  // namespace gantry::motion::test
