#include "app/record/planned_path.hpp"

#include <algorithm>

#include "motion/geometry.hpp"
#include "motion/profile/planner.hpp"

namespace gantry::record {
namespace {

constexpr double kStep_s = 0.005;

motion::Profile profile_of(const motion::Segment& segment) {
  return {{0, segment.nominal.v0, segment.nominal.a0}, segment.nominal.phases};
}

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
    const auto profile = profile_of(segment);
    const double length = segment.geometry.length, lasts_s = motion::duration(profile);
    for (double t = 0;; t = std::min(t + kStep_s, lasts_s)) {
      const double s = std::clamp(motion::evaluate(profile, t).p, 0.0, length);
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
