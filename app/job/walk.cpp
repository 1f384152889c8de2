#include "app/job/walk.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "app/job/block_builder.hpp"
#include "app/job/limits.hpp"
#include "core/units.hpp"

namespace gantry::job {
namespace {

constexpr double kLinear_mm = 1, kRotary_rad = units::rad(3);
constexpr double kAWay_s = 0.5;   // at constant speed
constexpr double kRests_s = 0.5;  // out there, so that the eye sees two motions

}  // namespace

double walk_distance(const config::Axis& axis) noexcept { return axis.rotary ? kRotary_rad : kLinear_mm; }

double walk_speed(const config::Axis& axis) noexcept { return std::min(walk_distance(axis) / kAWay_s, axis.v_max); }

std::string walk_in_words(const config::Axis& axis) {
  const auto shown = [&](double value) { return axis.rotary ? units::deg(value) : value; };
  const char* const unit = axis.rotary ? "deg" : "mm";
  return fmt::format("{:.6g} {} at {:.6g} {}/s", shown(walk_distance(axis)), unit, shown(walk_speed(axis)), unit);
}

Result<ProvenBlock> plan_walk(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                              const config::Axis& axis, bool all_referenced) {
  const motion::Limits limits = limits_of(machine);
  AxisVec out = at;
  out[axis.id.value] += walk_distance(axis);
  if (all_referenced && out[axis.id.value] > axis.p_max)
    return fail(Fault::OutOfReach, "it stands at its upper limit; `jog` it down, or walk before the machine is homed",
                "axis " + axis.name);
  BlockBuilder builder(limits, around.scene(), 1, at);
  const auto go = [&](const AxisVec& to) {
    return all_referenced ? builder.straight(to, around.no_nearer_than(at), walk_speed(axis))
                          : builder.unplaced(to, walk_speed(axis), walk_distance(axis));
  };
  if (auto r = go(out); !r) return tl::unexpected(r.error());
  if (auto r = builder.dwell(kRests_s); !r) return tl::unexpected(r.error());
  if (auto r = go(at); !r) return tl::unexpected(r.error());
  return builder.finish();
}

}  // namespace gantry::job
