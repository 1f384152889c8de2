#include "app/job/prove.hpp"

#include <algorithm>

#include "app/job/block_plan.hpp"

namespace gantry::job {

Result<NominalProof> prove_nominal(const config::Machine& machine, const recipes::Recipe& recipe,
                                   const recipes::Job& job) {
  BlockPlanner planner(machine, recipe);
  AxisVec at{};
  for (const auto& [axis, position] : machine.park) at[axis.value] = position;
  NominalProof proof{.motions = 0, .minimum_clearance_mm = 1e9, .duration_s = 0};
  const auto go = [&](const Result<PlannedBlock>& planned) -> Result<void> {
    if (!planned) return tl::unexpected(planned.error());
    proof.motions += planned->motions;
    proof.minimum_clearance_mm = std::min(proof.minimum_clearance_mm, planned->minimum_clearance_mm);
    proof.duration_s += planned->duration_s;
    at = planned->end;
    return {};
  };
  bool offset_known = false, surface_known = false;
  for (const recipes::Block& block : job.blocks) {
    if (recipes::needs_offset(block) && !offset_known)
      planner.know({}, {}, recipe.touches.empty()), offset_known = true;
    if (recipes::needs_surface(block) && !surface_known) planner.know({}, {}, true), surface_known = true;
    Result<void> done;
    if (const auto* mark = std::get_if<recipes::LookAtMark>(&block.what))
      done = go(planner.look_at_mark(block.number, at, mark->mark));
    else if (const auto* touch = std::get_if<recipes::Touch>(&block.what))
      done = go(planner.touch(block.number, at, touch->touch));
    else if (const auto* dispense = std::get_if<recipes::Dispense>(&block.what))
      done = go(planner.dispense(block.number, at, dispense->features));
    else
      done = go(planner.park(block.number, at));
    if (done && std::holds_alternative<recipes::Touch>(block.what)) done = go(planner.retract(block.number, at));
    if (!done) return tl::unexpected(done.error());
  }
  return proof;
}

}  // namespace gantry::job
