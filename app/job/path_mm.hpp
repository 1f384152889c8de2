// Length of path, as Snapshot::along_block_mm counts it: a dwell, whose length is seconds, adds none.
#pragma once
#include "motion/types.hpp"

namespace gantry::job {

[[nodiscard]] inline double path_mm(const motion::Segment& s) {
  return s.kind == motion::SegmentKind::Dwell ? 0 : s.geometry.length;
}

}  // namespace gantry::job
