#include "sim/world/head.hpp"

#include <cmath>

namespace gantry::sim {

double bottom(const config::Body& body) { return body.centre.z - body.shape.size.z / 2; }

namespace {

Tip true_tip(const config::Machine& machine, std::string_view name, Vec3 error) {
  const config::Tool* tool = config::find_tool(machine, name);
  if (tool == nullptr) return {};
  return {tool->tip + error, tool->lift_mm != 0, false, true};
}

/// The body whose lowest point is the tool's configured tip, within what a drawing rounds.
int body_of(const config::Machine& machine, std::string_view name) {
  constexpr double kNear_mm = 1.0;
  const config::Tool* tool = config::find_tool(machine, name);
  if (tool == nullptr) return -1;
  for (std::size_t i = 0; i < machine.head.size(); ++i) {
    const config::Body& b = machine.head[i];
    if (std::hypot(b.centre.x - tool->tip.x, b.centre.y - tool->tip.y) <= kNear_mm &&
        std::abs(bottom(b) - tool->tip.z) <= kNear_mm)
      return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

Head::Head(const config::Machine& machine)
    : needle(true_tip(machine, "needle", machine.sim.needle_error)),
      camera(true_tip(machine, "camera", machine.sim.camera_error)),
      probe(true_tip(machine, "probe", machine.sim.probe_error)),
      bodies(machine.head),
      probe_body(body_of(machine, "probe")),
      x_(machine.x.value),
      y_(machine.y.value),
      z_(machine.z.value),
      u_(machine.u ? machine.u->value : 0),
      c_(machine.c ? machine.c->value : 0),
      has_lift_(machine.u.has_value()),
      has_turn_(machine.c.has_value()),
      turn_axis_(config::turn_axis(machine)) {
  if (probe_body >= 0) {
    auto& body = bodies[static_cast<std::size_t>(probe_body)];
    body.centre = body.centre + machine.sim.probe_error;
    probe.on_turn = body.on_turn;
  }
  if (const int i = body_of(machine, "needle"); i >= 0) {
    auto& body = bodies[static_cast<std::size_t>(i)];
    body.centre = body.centre + machine.sim.needle_error;
    needle.on_turn = body.on_turn;
  }
}

double Head::swing_mm(const config::Body& body) const noexcept {
  if (!body.on_turn || !has_turn_) return 0;
  const double to_centre = std::hypot(body.centre.x - turn_axis_.x, body.centre.y - turn_axis_.y);
  return to_centre + std::hypot(body.shape.size.x, body.shape.size.y) / 2;
}

}  // namespace gantry::sim
