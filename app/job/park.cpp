#include "app/job/park.hpp"

#include <fmt/format.h>

#include "app/job/block_builder.hpp"
#include "app/job/limits.hpp"
#include "app/job/rise.hpp"

namespace gantry::job {

std::uint32_t park_axes(const config::Machine& machine) {
  std::uint32_t axes = 0;
  for (const auto& [axis, position] : machine.park) axes |= 1u << axis.value;
  return axes;
}

AxisVec parked(const config::Machine& machine, AxisVec at) {
  for (const auto& [axis, position] : machine.park) at[axis.value] = position;
  return at;
}

Result<ProvenBlock> plan_park(const config::Machine& machine, const Surroundings& around, const AxisVec& at) {
  const motion::Limits limits = limits_of(machine);
  BlockBuilder builder(limits, around.scene(), 1, at);
  if (auto r = add_rise(machine, around, builder); !r) return tl::unexpected(r.error());
  const AxisVec to = parked(machine, builder.at());
  const auto cannot = [](const Error& e) {
    return fail(e.fault, fmt::format("the head cannot go to the park position: {}", e.message), e.where);
  };
  if (auto r = builder.travel(to, around.apart()); !r) return cannot(r.error());
  auto block = builder.finish();
  if (!block) return cannot(block.error());
  return block;
}

}  // namespace gantry::job
