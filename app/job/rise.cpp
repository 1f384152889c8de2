#include "app/job/rise.hpp"

#include <fmt/format.h>

#include "app/job/limits.hpp"

namespace gantry::job {
namespace {

constexpr double kLow_mm = 0.5;  // less below the safe height is up there

}  // namespace

bool rises(const config::Machine& machine, const AxisVec& at) {
  return at[machine.z.value] < machine.safe_z_mm - kLow_mm;
}

Result<bool> add_rise(const config::Machine& machine, const Surroundings& around, BlockBuilder& builder) {
  const AxisVec from = builder.at();
  if (!rises(machine, from)) return false;
  AxisVec to = from;
  to[machine.z.value] = machine.safe_z_mm;
  const auto up = builder.straight(to, around.no_nearer_than(from));
  if (up) return true;
  if (up.error().fault != Fault::Collision) return tl::unexpected(up.error());
  return fail(
      Fault::Collision,
      fmt::format("the head cannot rise from Z {:.3f} mm to the safe height {:.3f} mm: {}; jog it clear of that "
                  "first, sideways or down",
                  from[machine.z.value], machine.safe_z_mm, up.error().message));
}

Result<std::optional<ProvenBlock>> plan_rise(const config::Machine& machine, const Surroundings& around,
                                             std::uint32_t block, const AxisVec& from, const motion::Opinion& opinion,
                                             const MotionRows* rows) {
  const motion::Limits limits = limits_of(machine);
  BlockBuilder builder(limits, around.scene(), block, from, {}, opinion);
  builder.list(rows);
  const auto rises = add_rise(machine, around, builder);
  if (!rises) return tl::unexpected(rises.error());
  if (!*rises) return std::nullopt;
  return builder.finish();
}

}  // namespace gantry::job
