#include "app/job/prove_homing.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <set>
#include <string>

#include "motion/plan/certificate.hpp"
#include "motion/plan/gap.hpp"

namespace gantry::job {
namespace {

constexpr double kReaction_s = 0.02;  // from the edge of the switch until the drive brakes

bool homes(const config::Axis& axis) { return axis.homing && axis.kind == config::AxisKind::Streamed; }

/// IEC 61800-7-201, 10.4: 35 and 37 home where the axis stands; 1, 2, 17 and 18 know their direction; the others may
/// run to a limit switch first.
bool stays(int method) { return method == 35 || method == 37; }
bool one_way(int method) { return method == 1 || method == 2 || (method >= 17 && method <= 22); }

/// All that a body of the head can be in while the axes are anywhere in a box: its own box, as wide as it gets.
motion::Solid swept(const motion::Scene& scene, const motion::SceneBody& body, const AxisVec& low,
                    const AxisVec& high) {
  Vec3 from = scene.carried(body, low), to = scene.carried(body, high);
  if (body.on_lift && scene.has_lift()) {  // a larger U is lower
    from.z = low[scene.z()] - high[scene.u()];
    to.z = high[scene.z()] - low[scene.u()];
  }
  motion::Solid box;
  box.centre = body.solid.centre + (from + to) * 0.5;
  box.half = body.half_box + (to - from) * 0.5;
  return box;
}

/// A pair that the box of positions does not keep apart. One axis alone moves the head on a line, which is swept as it
/// is; several span a box of which the bodies' own boxes are swept.
std::optional<motion::PairMargin> meets(const motion::Scene& scene, const AxisVec& low, const AxisVec& high,
                                        const motion::Margins& margins) {
  std::size_t moving = 0;
  for (std::size_t i = 0; i < scene.axes().size(); ++i) moving += low[i] != high[i];
  if (moving <= 1) {
    const auto hit = motion::first_hit(scene, low, high, margins);
    if (!hit) return std::nullopt;
    return motion::PairMargin{hit->head, hit->standing, hit->clearance_mm};
  }
  for (std::size_t i = 0; i < scene.head().size(); ++i) {
    const motion::Solid body = swept(scene, scene.head()[i], low, high);
    for (std::size_t k = 0; k < scene.standing().size(); ++k) {
      const double margin = margins.of(i, k);
      if (!(motion::gap(body, {}, scene.standing()[k].solid, margin).lower > margin))
        return motion::PairMargin{i, k, margin};
    }
  }
  return std::nullopt;
}

}  // namespace

HomingRange homing_range(const config::Axis& axis, double at) {
  const config::Homing& h = *axis.homing;
  if (stays(h.method)) return {at, at};
  const double beyond = h.fast * kReaction_s + (h.acceleration > 0 ? h.fast * h.fast / (2 * h.acceleration) : 0);
  const HomingRange range{std::min(at, h.position - beyond), std::max(at, h.position + beyond)};
  if (one_way(h.method)) return range;
  return {std::min(range.low, axis.p_min - beyond), std::max(range.high, axis.p_max + beyond)};
}

Result<void> prove_homing(const config::Machine& machine, const Surroundings& around, const AxisVec& at) {
  const motion::Scene& scene = around.scene();
  std::set<int> orders;
  for (const config::Axis& axis : machine.axes)
    if (homes(axis)) orders.insert(axis.homing->order);
  AxisVec now = at;
  for (const int order : orders) {
    const motion::PathRules rules = around.no_nearer_than(now);
    const auto margins = motion::make_margins(scene, rules.clearance_mm, rules.approaches);
    if (!margins) return tl::unexpected(margins.error());
    AxisVec low = now, high = now;
    std::string names;
    for (const config::Axis& axis : machine.axes) {
      if (!homes(axis) || axis.homing->order != order) continue;
      const HomingRange range = homing_range(axis, now[axis.id.value]);
      low[axis.id.value] = range.low, high[axis.id.value] = range.high;
      if (!stays(axis.homing->method)) now[axis.id.value] = axis.homing->position;
      names += (names.empty() ? "" : ", ") + axis.name;
    }
    if (const auto met = meets(scene, low, high, *margins))
      return fail(
          Fault::Collision,
          fmt::format("while {} home, {} could come within {:.3g} mm of {}; park the head, or "
                      "jog it clear of that, and home then",
                      names, scene.head()[met->head].name, met->clearance_mm, scene.standing()[met->standing].name));
  }
  return {};
}

}  // namespace gantry::job
