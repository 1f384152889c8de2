#include "motion/path/moves.hpp"

#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::motion {

double path_length(const Limits& limits, const AxisVec& displacement) {
  double linear = 0, rotary = 0;
  for (std::size_t i = 0; i < limits.axes; ++i)
    (limits.linear[i] ? linear : rotary) += displacement[i] * displacement[i];
  // What rounding leaves of a linear axis that stands is no path; a turn beside it is one.
  constexpr double kStands_mm = 1e-3;
  return std::sqrt(linear > kStands_mm * kStands_mm ? linear : std::max(linear, rotary));
}

std::vector<Segment> line_move(const Limits& limits, const AxisVec& from, const AxisVec& to, double v_cap) {
  AxisVec displacement{}, direction{};
  for (std::size_t i = 0; i < limits.axes; ++i) displacement[i] = to[i] - from[i];
  const double length = path_length(limits, displacement);
  if (!(length > 1e-12)) return {};
  for (std::size_t i = 0; i < limits.axes; ++i) direction[i] = displacement[i] / length;

  Segment s;
  s.feature = kTravel;
  s.geometry = straight(from, displacement, length);
  Bounds bounds = line_bounds(limits, direction);
  bounds.v = s.v_cap = std::min(v_cap, bounds.v);
  const Profile shortest = move({0, 0, 0}, {length, 0, 0}, bounds).profile;
  const double seconds = duration(shortest);
  for (const Phase& phase : stretched(shortest, whole_ticks(seconds, limits.tick_s) / seconds).phases)
    s.nominal.phases.push_back(phase);
  return {s};
}

std::vector<Segment> probe_move(const Limits& limits, const AxisVec& from, const AxisVec& to, double v_cap) {
  std::vector<Segment> move = line_move(limits, from, to, v_cap);
  for (Segment& s : move) {
    s.kind = SegmentKind::UntilProbe;
    s.ends_block = true;
  }
  return move;
}

Segment dwell(const Limits& limits, const AxisVec& q, double seconds, std::span<const OutputEvent> events) {
  Segment s;
  s.kind = SegmentKind::Dwell;
  s.geometry = standing(q, std::max(whole_ticks(seconds, limits.tick_s), limits.tick_s));
  s.nominal.v0 = 1;  // s is time
  s.nominal.phases.push_back({s.geometry.length, 0});
  s.v_cap = 1;
  for (const OutputEvent& e : events) s.events.push_back(e);
  return s;
}

bool within(const Limits& limits, const AxisVec& q) {
  for (std::size_t i = 0; i < limits.axes; ++i)
    if (!(q[i] >= limits.axis[i].p_min && q[i] <= limits.axis[i].p_max)) return false;
  return true;
}

double duration(std::span<const Segment> segments) {
  double sum = 0;
  for (const Segment& s : segments) sum += duration(s.nominal);
  return sum;
}

}  // namespace gantry::motion
