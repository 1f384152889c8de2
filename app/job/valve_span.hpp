// Where along the motion of one feature the valve is told to open and to shut.
//   if (const auto span = valve_span(segments.begin(), segments.end(), feature)) span->opens_mm ...
#pragma once
#include <cstdint>
#include <deque>
#include <optional>

#include "app/job/path_mm.hpp"
#include "motion/types.hpp"

namespace gantry::job {

using SegmentIterator = std::deque<motion::Segment>::const_iterator;

struct ValveSpan {
  double opens_mm = 0, shuts_mm = 0;  ///< along the segments, from the first one's begin
};

/// Nothing where the feature has not both. Of one that opens it more than once the last counts.
inline std::optional<ValveSpan> valve_span(SegmentIterator first, SegmentIterator last, std::uint32_t feature) {
  double along_block_mm = 0;
  std::optional<double> opens, shuts;
  for (auto s = first; s != last; ++s) {
    if (s->feature == feature)
      for (const motion::OutputEvent& e : s->events) (e.dispense ? opens : shuts) = along_block_mm + e.at_s;
    along_block_mm += path_mm(*s);
  }
  if (!opens || !shuts) return std::nullopt;
  return ValveSpan{*opens, *shuts};
}

}  // namespace gantry::job
