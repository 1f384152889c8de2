#include "app/run/prove.hpp"

#include <algorithm>

#include "app/run/block_plan.hpp"

namespace gantry::run {

Result<NominalProof> prove_nominal(const config::Machine& machine, const recipes::Recipe& recipe,
                                   const recipes::Job& job) {
  BlockPlanner planner(machine, recipe);
  AxisVec at{};
  for (const auto& [axis, position] : machine.park) at[axis.value] = position;
  NominalProof proof{.motions = 0, .minimum_clearance_mm = 1e9, .duration_s = 0};
  bool offset_known = false, surface_known = false;
  for (const recipes::Block& block : job.blocks) {
    const bool marks_over = !std::holds_alternative<recipes::LookAtMark>(block.what);
    const bool touches_over = marks_over && !std::holds_alternative<recipes::Touch>(block.what);
    if (marks_over && !offset_known) planner.know({}, {}, recipe.touches.empty()), offset_known = true;
    if (touches_over && !surface_known) planner.know({}, {}, true), surface_known = true;
    Result<PlannedBlock> planned;
    if (const auto* mark = std::get_if<recipes::LookAtMark>(&block.what))
      planned = planner.look_at_mark(block.number, at, mark->mark);
    else if (const auto* touch = std::get_if<recipes::Touch>(&block.what))
      planned = planner.touch(block.number, at, touch->touch);
    else if (const auto* dispense = std::get_if<recipes::Dispense>(&block.what))
      planned = planner.dispense(block.number, at, dispense->features);
    else
      planned = planner.park(block.number, at);
    if (!planned) return tl::unexpected(planned.error());
    proof.motions += planned->motions;
    proof.minimum_clearance_mm = std::min(proof.minimum_clearance_mm, planned->minimum_clearance_mm);
    proof.duration_s += planned->duration_s;
    at = planned->end;
    if (std::holds_alternative<recipes::Touch>(block.what)) {
      const auto up = planner.retract(block.number, at);
      if (!up) return tl::unexpected(up.error());
      at = up->end;
    }
  }
  return proof;
}

}  // namespace gantry::run
