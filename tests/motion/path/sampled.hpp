// Segments played in time by themselves, in long double, apart from the planner and the interpolator.
#pragma once
#include <vector>

#include "motion/geometry.hpp"
#include "motion/types.hpp"

namespace gantry::motion::test {

inline long double duration_of(const Segment& s) {
  long double t = 0;
  for (const Phase& phase : s.nominal.phases) t += phase.duration_s;
  return t;
}

struct PathState {
  long double s = 0, v = 0, a = 0;
};
inline PathState path_state(const Segment& segment, long double t) {
  PathState x{0, segment.nominal.v0, segment.nominal.a0};
  for (const Phase& phase : segment.nominal.phases) {
    const long double dt = std::min<long double>(t, phase.duration_s), j = phase.jerk;
    x.s += dt * (x.v + dt * (x.a / 2 + dt * j / 6));
    x.v += dt * (x.a + dt * j / 2);
    x.a += dt * j;
    t -= dt;
    if (t <= 0) break;
  }
  return x;
}

/// Axis positions every h from the start of the chain to its end.
inline std::vector<AxisVec> sampled(const std::vector<Segment>& chain, double h) {
  std::vector<AxisVec> out;
  long double begin = 0;
  std::size_t n = 0;
  for (const Segment& s : chain) {
    const long double end = begin + duration_of(s);
    for (; n * (long double)h <= end; ++n)
      out.push_back(point(s.geometry, static_cast<double>(path_state(s, n * (long double)h - begin).s)));
    begin = end;
  }
  return out;
}

}  // namespace gantry::motion::test
