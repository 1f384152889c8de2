#include "app/job/limits.hpp"

namespace gantry::job {

motion::Limits limits_of(const config::Machine& machine) {
  motion::Limits limits;
  limits.axes = machine.axes.size();
  limits.tick_s = seconds(machine.bus.cycle);
  for (std::size_t i = 0; i < machine.axes.size(); ++i) {
    const config::Axis& a = machine.axes[i];
    limits.axis[i] = {a.p_min, a.p_max, a.v_max, a.a_max, a.j_max};
  }
  for (const AxisId id : {machine.x, machine.y, machine.z}) limits.linear[id.value] = true;
  return limits;
}

}  // namespace gantry::job
