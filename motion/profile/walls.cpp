// Position limits.
#include "motion/profile/corridor.hpp"

namespace gantry::motion {

Reason append_between_walls(const State& from, const State& to, const AxisBounds& bounds, Profile& profile,
                            double resolution) noexcept {
  Corridor corridor(from, to, bounds, resolution, profile.phases.size());
  if (!corridor.inside(profile)) return Reason::StartCannotStay;
  const Route route = corridor.shortest();
  return route && corridor.write(route, profile) ? Reason::Solved : corridor.reason_of_none();
}

}  // namespace gantry::motion
