#include "app/record/planned_path.hpp"

#include <algorithm>

#include "motion/geometry.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::record {
namespace {

constexpr double kStep_s = 0.005;

}  // namespace

PlannedPath::PlannedPath(const config::Machine& machine)
    : xyz_{machine.x.value, machine.y.value, machine.z.value},
      lift_(machine.u ? std::optional<std::size_t>(machine.u->value) : std::nullopt) {}

PathPoint PlannedPath::at(const motion::Segment& segment, double s, double t_s) const {
  const AxisVec q = motion::point(segment.geometry, s);
  return {.t_s = t_s,
          .head = {q[xyz_[0]], q[xyz_[1]], q[xyz_[2]]},
          .block = segment.block,
          .valve = valve_,
          .lift_mm = lift_ ? q[*lift_] : 0};
}

void PlannedPath::add(std::span<const motion::Segment> segments) {
  for (const auto& segment : segments) {
    const double length = segment.geometry.length, lasts_s = motion::duration(segment.nominal);
    for (double t = 0;; t = std::min(t + kStep_s, lasts_s)) {
      const double s = std::clamp(motion::along(segment.nominal, t).x.p, 0.0, length);
      for (const auto& event : segment.events)
        if ((event.mask & config::bit(config::Output::Valve)) != 0 && (s >= event.at_s || t >= lasts_s))
          valve_ = (event.value & config::bit(config::Output::Valve)) != 0;
      path_.add(at(segment, s, t_s_ + t));
      if (t >= lasts_s) break;
    }
    t_s_ += lasts_s;
  }
}

}  // namespace gantry::record
