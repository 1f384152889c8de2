// The planned path of a job for the report: segments played at their planned speed, thinned like the actual path.
//   PlannedPath planned(machine);   planned.add(segments); ...   result.planned = planned.take();
// Time runs through the segments alone; the report lays each block beside the actual one.
#pragma once
#include <span>
#include <vector>

#include "app/record/job_result.hpp"
#include "app/record/trace.hpp"
#include "config/machine.hpp"
#include "motion/types.hpp"

namespace gantry::record {

class PlannedPath {
 public:
  explicit PlannedPath(const config::Machine& machine);
  void add(std::span<const motion::Segment> segments);
  [[nodiscard]] Path take() { return path_.take(); }

 private:
  PathPoint at(const motion::Segment& segment, double s, double t_s) const;

  std::array<std::size_t, 3> xyz_;
  std::optional<std::size_t> lift_;
  ThinPath path_;
  double t_s_ = 0;
  bool valve_ = false;
};

}  // namespace gantry::record
