// Straight up to the safe height, from wherever a stop has left the head: the first motion of a job, and what may
// follow an operator's hold or abort.
//   auto up = plan_rise(machine, surroundings, number, at);      // Result<std::optional<ProvenBlock>>
#pragma once
#include <cstdint>
#include <optional>

#include "app/job/block_builder.hpp"
#include "app/job/proven_block.hpp"
#include "app/job/surroundings.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"

namespace gantry::job {

/// Nothing when the head is up there already. What stands nearer to the head than the clearance comes no nearer, as in
/// a jog (Surroundings::no_nearer_than). `rows` list its motions in the block. Fault::Collision with both bodies, the
/// point, and how to get out.
Result<std::optional<ProvenBlock>> plan_rise(const config::Machine& machine, const Surroundings& around,
                                             std::uint32_t block, const AxisVec& from,
                                             const motion::Opinion& opinion = {}, const MotionRows* rows = nullptr);
/// The head stands lower than that.
bool rises(const config::Machine& machine, const AxisVec& at);
/// The same as the beginning of a block that goes on from up there. False: it is up there already.
Result<bool> add_rise(const config::Machine& machine, const Surroundings& around, BlockBuilder& builder);

}  // namespace gantry::job
