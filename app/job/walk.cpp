#include "app/job/walk.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "app/job/block_builder.hpp"
#include "app/job/limits.hpp"
#include "config/look_alikes.hpp"
#include "core/units.hpp"

namespace gantry::job {
namespace {

constexpr double kLinear_mm = 1, kRotary_rad = units::rad(3);
constexpr double kOut_s = 0.5;    // at constant speed
constexpr double kRests_s = 0.5;  // out there, so that the eye sees two motions

/// Orders to the one may come to the motor of the other: one station has both, or their stations look alike.
bool confusable(const config::Machine& machine, const config::Axis& a, const config::Axis& b) {
  return std::ranges::any_of(a.drives, [&](const config::DriveRef& mine) {
    return std::ranges::any_of(b.drives, [&](const config::DriveRef& its) {
      return mine.station == its.station ||
             config::look_alike(machine.stations[mine.station.value], machine.stations[its.station.value]);
    });
  });
}

}  // namespace

double walk_most(const config::Axis& axis) noexcept { return axis.rotary ? kRotary_rad : kLinear_mm; }

double walk_by(const config::Machine& machine, const config::Axis& axis) noexcept {
  double counts = walk_most(axis) * axis.counts_per_unit;
  for (const config::Axis& other : machine.axes)
    if (other.kind == config::AxisKind::Streamed && confusable(machine, axis, other))
      counts = std::min(counts, walk_most(other) * other.counts_per_unit);
  const double by = counts / axis.counts_per_unit;
  return machine.u && axis.id == *machine.u ? -by : by;
}

double walk_speed(const config::Machine& machine, const config::Axis& axis) noexcept {
  return std::min(std::abs(walk_by(machine, axis)) / kOut_s, axis.v_max);
}

std::string walk_in_words(const config::Machine& machine, const config::Axis& axis) {
  const auto shown = [&](double value) { return axis.rotary ? units::deg(value) : value; };
  const char* const unit = axis.rotary ? "deg" : "mm";
  return fmt::format("{:+.3g} {} at {:.3g} {}/s", shown(walk_by(machine, axis)), unit, shown(walk_speed(machine, axis)),
                     unit);
}

Result<ProvenBlock> plan_walk(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                              const config::Axis& axis, bool all_referenced) {
  const motion::Limits limits = limits_of(machine);
  AxisVec out = at;
  out[axis.id.value] += walk_by(machine, axis);
  if (all_referenced && (out[axis.id.value] > axis.p_max || out[axis.id.value] < axis.p_min))
    return fail(Fault::OutOfReach, "it stands at its limit; `jog` it away from there", "axis " + axis.name);
  BlockBuilder builder(limits, around.scene(), 1, at);
  const auto go = [&](const AxisVec& to) {
    return all_referenced ? builder.straight(to, around.no_nearer_than(at), walk_speed(machine, axis))
                          : builder.unplaced(to, walk_speed(machine, axis), walk_most(axis));
  };
  if (auto r = go(out); !r) return tl::unexpected(r.error());
  if (auto r = builder.dwell(kRests_s); !r) return tl::unexpected(r.error());
  if (auto r = go(at); !r) return tl::unexpected(r.error());
  return builder.finish();
}

}  // namespace gantry::job
