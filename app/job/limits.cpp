#include "app/job/limits.hpp"

#include "motion/plan/as_sent.hpp"

namespace gantry::job {

motion::Limits limits_of(const config::Machine& machine) {
  motion::Limits limits;
  limits.axes = machine.axes.size();
  limits.tick_s = seconds(machine.bus.cycle);
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const config::Axis& a = machine.axes[i];
    limits.axis[i] = {a.p_min, a.p_max, a.v_max, a.a_max, a.j_max};
    limits.response_delay_s[i] = a.response_delay_s;
    a.name.copy(limits.name[i].data(), limits.name[i].size() - 1);
  }
  for (const AxisId id : {machine.x, machine.y, machine.z}) limits.linear[id.value] = true;
  return limits;
}

double kept_mm(const config::Machine& machine, const motion::Scene& scene) {
  AxisVec off{};
  for (const config::Axis& axis : machine.axes) off[axis.id.value] = axis.path_error;
  return machine.clearance_mm + motion::farthest_mm(scene, off);
}

}  // namespace gantry::job
