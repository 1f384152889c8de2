#include "app/job/hold_ahead.hpp"

#include <algorithm>
#include <optional>

#include "app/job/stop_ahead.hpp"
#include "motion/geometry.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/speed_profile.hpp"
#include "motion/rt/compensation.hpp"

namespace gantry::job {
namespace {

/// From where the planned time of this segment is `t_s`.
double stop_s(const motion::Segment& segment, double t_s, double rate, const motion::Limits& limits) {
  const motion::State x = motion::along(segment.nominal, t_s).x;
  const motion::Bounds bounds = motion::line_bounds(limits, motion::derivative<1>(segment.geometry, x.p));
  return motion::duration(motion::stop({0, x.v * rate, x.a * rate * rate}, bounds).profile);
}

}  // namespace

double stands_in_s(const std::deque<motion::Segment>& block, InBlock at, std::uint32_t feature, double rate,
                   const motion::Limits& limits) {
  constexpr double kSamePoint_mm = 1e-6;
  const int behind = motion::Compensation(limits, limits.response_delay_s).delay_ticks();
  const double delay_s = (behind + 1) * limits.tick_s;  // until none of the last cycles has the valve open
  double begin_mm = 0, begin_s = 0;
  std::optional<double> holds_s;
  for (const motion::Segment& segment : block) {
    const bool moves = segment.kind != motion::SegmentKind::Dwell;
    const double end_mm = begin_mm + path_mm(segment), lasts_s = motion::duration(segment.nominal);
    if (end_mm < at.along_mm - (moves ? 0 : kSamePoint_mm)) {
      begin_mm = end_mm;
      continue;
    }
    double gone_s = 0;
    if (moves)
      gone_s = std::min(lasts_s, motion::time_at(segment.nominal, std::max(0.0, at.along_mm - begin_mm)));
    else if (begin_mm <= at.along_mm + kSamePoint_mm)
      at.stands_s -= gone_s = std::min(lasts_s, at.stands_s);
    if (!holds_s && !moves && segment.feature != feature) continue;
    const double slower = moves ? rate : 1;
    const double end_s = begin_s + (lasts_s - gone_s) / slower;
    if (!holds_s && segment.feature == feature)
      for (const motion::OutputEvent& event : segment.events)
        if (!event.dispense)
          holds_s =
              std::max(0.0, begin_s + (motion::time_at(segment.nominal, event.at_s) - gone_s) / slower - event.lead_s) +
              std::max(delay_s, event.lead_s + limits.tick_s);  // not before the end of what it lays
    if (holds_s && *holds_s < end_s) {
      if (!moves) return *holds_s;
      const double stands_s = *holds_s + stop_s(segment, gone_s + (*holds_s - begin_s) * slower, slower, limits);
      const bool rests = segment.kind != motion::SegmentKind::Piece || segment.rests;
      return (rests ? std::min(stands_s, end_s) : stands_s) + behind * limits.tick_s;  // the drives
    }
    begin_mm = end_mm, begin_s = end_s;
  }
  return holds_s.value_or(delay_s);
}

}  // namespace gantry::job
