// From wherever the head stands to the machine's park position: straight up to the safe height where it is lower, then
// a path that is free at full clearance.
//   auto planned = plan_park(machine, surroundings, at);      // Result<ProvenBlock>
// Both motions are one block: nothing moves unless the whole of it is proved, and a hold or an abort brakes on it.
#pragma once
#include <cstdint>

#include "app/job/proven_block.hpp"
#include "app/job/surroundings.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"

namespace gantry::job {

/// The axes that the park position names, bit n: AxisId n.
std::uint32_t park_axes(const config::Machine& machine);

/// The park position; axes that it does not name stay as in `at`.
AxisVec parked(const config::Machine& machine, AxisVec at);

/// One block, number 1; axes that the park position does not name stay. It opens no valve. Fault::Collision with both
/// bodies and the point.
Result<ProvenBlock> plan_park(const config::Machine& machine, const Surroundings& around, const AxisVec& at);

}  // namespace gantry::job
