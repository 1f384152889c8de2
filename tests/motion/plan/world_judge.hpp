// The simulated world as a judge of paths: its own collision watch (sim/world/collisions.hpp), which shares no code
// with the planner, looks at each millisecond of a path that is gone at 200 mm/s.
//   WorldJudge judge(scene);   judge.collides(points)   // true: the world has seen a contact
// Bodies of the head are larger by what is surely within the clearance of them, so that it judges that as well.
#pragma once
#include <span>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "sim/world/obstacles.hpp"

namespace gantry::test {

/// A body as the planner is told of it, and as it truly stands.
struct Stands {
  config::Body told;
  sim::Solid truly;
};
inline Stands upright(const config::Body& body) {
  return {body, {body.name, body.shape, body.centre, body.rotation_rad, {}}};
}
/// A box that leans by `slope`; the planner is told of the upright box about it.
Stands leaning(const config::Body& box, Vec2 slope);

class WorldJudge {
 public:
  WorldJudge(const config::Machine& machine, std::vector<sim::Solid> truly);
  [[nodiscard]] bool collides(std::span<const AxisVec> path) const;

 private:
  config::Machine machine_;
  std::vector<sim::Solid> truly_;
};

}  // namespace gantry::test
