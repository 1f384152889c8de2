#include "app/job/jog.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

#include "app/job/hold_to_run.hpp"
#include "app/job/limits.hpp"
#include "core/near_word.hpp"
#include "core/units.hpp"
#include "motion/path/moves.hpp"
#include "motion/profile/line_bounds.hpp"

namespace gantry::job {
namespace {

using units::Dimension;

constexpr double kSpeed_mm_s = 20;
constexpr double kSpeed_rad_s = units::rad(20);
constexpr double kLeast_mm = 1e-4, kLeast_rad = units::rad(1e-4);  // less than a drive counts
constexpr double kRounding = 1e-9;

std::string shown(const config::Axis& axis, double value) {
  const double in_units = axis.rotary ? units::deg(value) : value;
  const char* const unit = axis.rotary ? "deg" : "mm";
  return std::abs(in_units) < 1e9 ? fmt::format("{:.3f} {}", in_units, unit) : fmt::format("{:.3g} {}", in_units, unit);
}

Result<const config::Axis*> streamed_axis(const config::Machine& machine, const std::string& name) {
  const auto axis = axis_named(machine, name);
  if (axis && (*axis)->kind == config::AxisKind::Positioned)
    return fail(Fault::PositionedAxisInMove,
                "it positions by itself, and jog moves only axes that get a target in every cycle", "axis " + name);
  return axis;
}

/// How far the jog goes in mm, or in rad where it turns only.
double length(const config::Machine& machine, const Jog& jog, bool rotary) {
  double sum = 0;
  for (const config::Axis& axis : machine.axes)
    if (axis.rotary == rotary) sum += jog.displacement[axis.id.value] * jog.displacement[axis.id.value];
  return std::sqrt(sum);
}

/// Along the line (motion/path/moves.hpp) so fast that mm axes together and axes that turn together keep the speeds of
/// a jog that names none.
double slow_cap(const config::Machine& machine, const Jog& jog) {
  const double line = motion::path_length(limits_of(machine), jog.displacement);
  double cap = motion::kNoCap;
  if (const double mm = length(machine, jog, false); mm > 0) cap = std::min(cap, kSpeed_mm_s * line / mm);
  if (const double rad = length(machine, jog, true); rad > 0) cap = std::min(cap, kSpeed_rad_s * line / rad);
  return cap;
}

/// A speed that a jog may not exceed, and why: "axis X can do 500.000 mm/s". Along the line (motion/path/moves.hpp).
struct Most {
  double cap = motion::kNoCap;
  std::string because{};
};

/// As fast as the axis can that allows least.
Most of_axes(const config::Machine& machine, const Jog& jog, double line) {
  Most most;
  for (const config::Axis& axis : machine.axes) {
    const double part = std::abs(jog.displacement[axis.id.value]);
    if (part == 0 || axis.v_max * line / part >= most.cap) continue;
    most.cap = axis.v_max * line / part;
    most.because = fmt::format("axis {} can do {}/s", axis.name, shown(axis, axis.v_max));
  }
  return most;
}

/// As fast as all axes stand in time on their line when the client falls silent. The axis that is named brakes slowest
/// by itself.
Most while_held(const config::Machine& machine, const Jog& jog, double line) {
  AxisVec direction{};
  const config::Axis* slowest = nullptr;
  double least = motion::kNoCap;
  const double within_s = hold_to_run::braking_s(machine);
  for (const config::Axis& axis : machine.axes) {
    const double part = std::abs(jog.displacement[axis.id.value]);
    if (part == 0) continue;
    direction[axis.id.value] = part / line;
    const double alone = hold_to_run::speed_that_stands(within_s, axis.a_max, axis.j_max) * line / part;
    if (alone >= least) continue;
    least = alone;
    slowest = &axis;
  }
  const motion::Bounds bounds = motion::line_bounds(limits_of(machine), direction);
  return {.cap = hold_to_run::speed_that_stands(within_s, bounds.a, bounds.j),
          .because = fmt::format("axis {} would else not stand within {} ms of its client's last word",
                                 slowest == nullptr ? "" : slowest->name, hold_to_run::kStands / milliseconds(1))};
}

}  // namespace

Result<const config::Axis*> axis_named(const config::Machine& machine, const std::string& name) {
  if (const config::Axis* axis = config::find_axis(machine, name)) return axis;
  std::vector<std::string_view> names;
  for (const config::Axis& a : machine.axes) names.push_back(a.name);
  return fail(Fault::Usage, fmt::format("there is no axis '{}'; {}", name, did_you_mean(name, names)));
}

Result<Jog> read_jog(const config::Machine& machine, const JogWords& words, JogFor whom) {
  if (words.by.empty()) return fail(Fault::Usage, "a jog names at least one axis and how far it goes: X 10mm");
  Jog jog;
  bool turns_only = true;
  for (const auto& [name, by] : words.by) {
    const auto axis = streamed_axis(machine, name);
    if (!axis) return tl::unexpected(axis.error());
    const auto value = units::parse(by, (*axis)->rotary ? Dimension::Angle : Dimension::Length);
    if (!value) return fail(Fault::Usage, value.error().message, "axis " + name);
    if (std::abs(*value) < ((*axis)->rotary ? kLeast_rad : kLeast_mm))
      return fail(Fault::Usage, fmt::format("a jog goes by at least {}", (*axis)->rotary ? "0.0001 deg" : "0.0001 mm"),
                  "axis " + name);
    jog.axes |= 1u << (*axis)->id.value;
    jog.displacement[(*axis)->id.value] = *value;
    turns_only = turns_only && (*axis)->rotary;
  }
  const double line = motion::path_length(limits_of(machine), jog.displacement);
  // What s is depends on the axes (motion/path/moves.hpp); the speed that is named is that of all mm axes together. An
  // axis that turns while others go somewhere follows them.
  const double along = length(machine, jog, turns_only);
  Most most = of_axes(machine, jog, line);
  if (whom == JogFor::Client) {
    if (Most held = while_held(machine, jog, line); held.cap < most.cap) most = std::move(held);
    if (most.cap * along / line < (turns_only ? kSlowestJog_rad_s : kSlowestJog_mm_s))
      return fail(Fault::NoSolution,
                  fmt::format("no jog stands within {} ms of its client's last word: {}",
                              hold_to_run::kStands / milliseconds(1),
                              hold_to_run::braking_s(machine) > 0
                                  ? "its axes brake too slowly"
                                  : "cycle and response_delay of the axes leave it no time to brake"),
                  "jog");
  }
  if (words.speed.empty()) {
    jog.v_cap = std::min(slow_cap(machine, jog), most.cap);
    return jog;
  }
  const auto asked = units::parse(words.speed, turns_only ? Dimension::AngularSpeed : Dimension::Speed);
  if (!asked) return fail(Fault::Usage, asked.error().message, "the speed");
  const double speed = *asked;
  if (!(speed >= (turns_only ? kSlowestJog_rad_s : kSlowestJog_mm_s)))
    return fail(Fault::Usage, fmt::format("a jog is no slower than {}", turns_only ? "0.01 deg/s" : "0.01 mm/s"),
                "the speed");
  constexpr double kSame = 1e-6;  // relative: a limit as somebody writes it
  const double can = most.cap * along / line;
  if (can < speed * (1 - kSame))
    jog.slowed = fmt::format("no faster than {:.6g} {}, because {}", turns_only ? units::deg(can) : can,
                             turns_only ? "deg/s" : "mm/s", most.because);
  jog.v_cap = std::min(speed * line / along, most.cap);
  return jog;
}

Result<void> know_position(const config::Machine& machine, std::uint32_t referenced, std::uint32_t axes) {
  for (const config::Axis& axis : machine.axes) {
    const std::uint32_t bit = 1u << axis.id.value;
    const bool streamed = axis.kind == config::AxisKind::Streamed;
    if ((referenced & bit) != 0 || ((axes & bit) == 0 && !streamed)) continue;
    return fail(Fault::NotReferenced,
                "it is not referenced, so that it is not known where the head stands; run `gantry home` first",
                "axis " + axis.name);
  }
  return {};
}

Result<ProvenBlock> plan_jog(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                             const Jog& jog) {
  AxisVec to = at;
  for (const config::Axis& axis : machine.axes) {
    const std::size_t i = axis.id.value;
    to[i] += jog.displacement[i];
    const bool up = jog.displacement[i] > 0;
    const double limit = up ? axis.p_max : axis.p_min;
    const double left = std::max(0.0, up ? limit - at[i] : at[i] - limit);
    if (jog.displacement[i] == 0 || (up ? to[i] - limit : limit - to[i]) <= kRounding) continue;
    const std::string room =
        shown(axis, left) == shown(axis, 0) ? " already" : fmt::format(", {} from there", shown(axis, left));
    return fail(Fault::OutOfReach,
                fmt::format("it would go to {}, past its {} limit {}; it stands at {}{}", shown(axis, to[i]),
                            up ? "upper" : "lower", shown(axis, limit), shown(axis, at[i]), room),
                "axis " + axis.name);
  }
  const motion::Limits limits = limits_of(machine);
  BlockBuilder builder(limits, around.scene(), 1, at);
  if (auto r = builder.straight(to, around.no_nearer_than(at), jog.v_cap); !r) return tl::unexpected(r.error());
  return builder.finish();
}

}  // namespace gantry::job
