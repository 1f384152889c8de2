// Where the parts of the head truly are for given axis coordinates. A point p of the head stands at p + (X, Y, Z),
// lower by U when it rides on the lift. A tool rides on the lift when it needs it (Tool::lift_mm).
#pragma once
#include <string_view>
#include <vector>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/vec.hpp"

namespace gantry::sim {

/// True tip of a tool in the head's frame: as configured plus the hidden error.
struct Tip {
  Vec3 at;
  bool on_lift = false;
  bool exists = false;  ///< the machine file names this tool
};

class Head {
 public:
  explicit Head(const config::Machine& machine);

  [[nodiscard]] Vec3 place(Vec3 p, bool on_lift, const AxisVec& q) const noexcept {
    return {p.x + q[x_], p.y + q[y_], p.z + q[z_] - (on_lift && has_lift_ ? q[u_] : 0.0)};
  }
  [[nodiscard]] Vec3 place(const Tip& tip, const AxisVec& q) const noexcept { return place(tip.at, tip.on_lift, q); }

  Tip needle, camera, probe;
  /// Bodies as configured; those that end in a tool's tip (found by geometry) carry the tool's error too.
  std::vector<config::Body> bodies;
  int probe_body = -1;  ///< the body that touches when the probe touches; -1: none ends in the probe's tip

 private:
  std::size_t x_, y_, z_, u_ = 0;
  bool has_lift_ = false;
};

/// Height of a body's lowest point over its frame's origin.
double bottom(const config::Body& body);

}  // namespace gantry::sim
