// Where the parts of the head truly are for given axis coordinates. A point p of the head stands at p + (X, Y, Z),
// lower by U when it rides on the lift. A tool rides on the lift when it needs it (Tool::lift_mm). What turns with C is
// turned before, about the upright line where the needle's tip is meant to be; a tool turns when the body does that
// ends in its tip.
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
  bool on_turn = false;
  bool exists = false;  ///< the machine file names this tool
};

class Head {
 public:
  explicit Head(const config::Machine& machine);

  [[nodiscard]] Vec3 in_machine(Vec3 p, bool on_lift, const AxisVec& q) const noexcept {
    return {p.x + q[x_], p.y + q[y_], p.z + q[z_] - (on_lift && has_lift_ ? q[u_] : 0.0)};
  }
  [[nodiscard]] Vec3 in_machine(const Tip& tip, const AxisVec& q) const noexcept {
    return in_machine(tip.on_turn ? turned(tip.at, q) : tip.at, tip.on_lift, q);
  }
  /// A body's centre, and how far it is turned from how it is configured.
  [[nodiscard]] Vec3 centre(const config::Body& body, const AxisVec& q) const noexcept {
    return in_machine(body.on_turn ? turned(body.centre, q) : body.centre, body.on_lift, q);
  }
  [[nodiscard]] double turn_rad(const config::Body& body, const AxisVec& q) const noexcept {
    return body.on_turn && has_turn_ ? q[c_] : 0.0;
  }
  /// From the line about which C turns to the farthest point of a body that turns with it; 0 of all others.
  [[nodiscard]] double swing_mm(const config::Body& body) const noexcept;

  Tip needle, camera, probe;
  /// Bodies as configured; those that end in a tool's tip (found by geometry) carry the tool's error too.
  std::vector<config::Body> bodies;
  int probe_body = -1;  ///< the body that touches when the probe touches; -1: none ends in the probe's tip

 private:
  [[nodiscard]] Vec3 turned(Vec3 p, const AxisVec& q) const noexcept {
    if (!has_turn_) return p;
    const Vec2 from_axis = rotated({p.x - turn_axis_.x, p.y - turn_axis_.y}, q[c_]);
    return {turn_axis_.x + from_axis.x, turn_axis_.y + from_axis.y, p.z};
  }

  std::size_t x_, y_, z_, u_ = 0, c_ = 0;
  bool has_lift_ = false, has_turn_ = false;
  Vec2 turn_axis_;
};

/// Height of a body's lowest point over its frame's origin.
double bottom(const config::Body& body);

}  // namespace gantry::sim
