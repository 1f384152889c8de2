#include "app/job/prove_homing.hpp"

#include <algorithm>
#include <bit>
#include <fmt/format.h>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/units.hpp"
#include "motion/plan/gap.hpp"
#include "motion/plan/sweep.hpp"

namespace gantry::job {
namespace {

constexpr double kReaction_s = 0.02;  // from the edge of the switch until the drive brakes

bool homes(const config::Axis& axis) { return axis.homing && axis.kind == config::AxisKind::Streamed; }

/// IEC 61800-7-201, 10.4: 35 and 37 home where the axis stands; 1, 2, 17 and 18 know their direction; the others may
/// run to a limit switch first.
bool stays(int method) { return method == 35 || method == 37; }
bool one_way(int method) { return method == 1 || method == 2 || (method >= 17 && method <= 22); }

/// Where the axes may be while those of one order home.
struct Stage {
  AxisVec low{}, high{};
  AxisVec lowest_start{};     ///< where the order begins; a lift of which that is not known is as far down as it may be
  bool lift_unknown = false;  ///< it may begin anywhere
  bool turn_unknown = false;  ///< C may begin anywhere
  bool only_rises = false;    ///< what is on the lift goes straight up and nowhere else ...
  AxisVec end_low{}, end_high{};  ///< ... but for here, where the lift may go down by what it needs to leave its edge
};

double beyond(const config::Homing& h) {
  return h.fast * kReaction_s + (h.acceleration > 0 ? h.fast * h.fast / (2 * h.acceleration) : 0);
}

constexpr double kTurnPart_rad = units::rad(1);  // what turns is looked at in parts of no less than this

/// The same for a body that turns: the box about it where C stands in the middle of its range, larger by what the rest
/// of the range moves it; where that is not apart, by halves of the range.
bool apart_turning(const motion::Scene& scene, const motion::SceneBody& body, std::size_t standing, const AxisVec& low,
                   const AxisVec& high, double margin_mm) {
  const std::size_t c = scene.c();
  const double half_turn = std::abs(high[c] - low[c]) / 2, middle = (low[c] + high[c]) / 2;
  motion::Solid there = motion::turned(body.solid, scene.turn_axis(), middle);
  there.disc = body.turning_mm * std::min(half_turn, 2.0);
  const Vec3 a = scene.carried(body, low), b = scene.carried(body, high);
  motion::Solid box;
  box.centre = there.centre + (a + b) * 0.5;
  box.half = motion::half_box(there) + Vec3{std::abs(b.x - a.x), std::abs(b.y - a.y), std::abs(b.z - a.z)} * 0.5;
  if (motion::gap(box, {}, scene.standing()[standing].solid, margin_mm).lower > margin_mm) return true;
  if (2 * half_turn <= kTurnPart_rad) return false;
  AxisVec first = high, second = low;
  first[c] = second[c] = middle;
  return apart_turning(scene, body, standing, low, first, margin_mm) &&
         apart_turning(scene, body, standing, second, high, margin_mm);
}

/// Whether a pair keeps its margin while the axes are anywhere between two corners. A body that is carried along one
/// line is swept as it is; of one that is carried anywhere in a box its own box is swept.
bool apart(const motion::Scene& scene, std::size_t head, std::size_t standing, AxisVec low, AxisVec high,
           double margin_mm) {
  const motion::SceneBody& body = scene.head()[head];
  if (scene.has_lift()) std::swap(low[scene.u()], high[scene.u()]);  // a larger U is lower
  const Vec3 displacement = scene.carried(body, high) - scene.carried(body, low);
  if (scene.turn_of(body, low, high) != 0) {
    if (displacement == Vec3{}) return motion::is_clear(scene, head, standing, low, high, margin_mm);
    return apart_turning(scene, body, standing, low, high, margin_mm);
  }
  if ((displacement.x != 0) + (displacement.y != 0) + (displacement.z != 0) <= 1)
    return motion::BodySweep(scene, head, low, high).prove(standing, margin_mm).has_value();
  motion::Solid box;
  const motion::Solid there = scene.placed(body, low);
  box.centre = there.centre + displacement * 0.5;
  box.half = motion::half_box(there) + displacement * 0.5;
  return motion::gap(box, {}, scene.standing()[standing].solid, margin_mm).lower > margin_mm;
}

/// Two convex bodies that would overlap at the lowest start: the head stands higher than that, and the distance along a
/// straight line is convex, so that whatever rises from where it really stands only goes away.
bool only_leaves(const motion::Scene& scene, const Stage& stage, std::size_t head, std::size_t standing,
                 double margin_mm) {
  const motion::SceneBody& body = scene.head()[head];
  if (!stage.lift_unknown || !stage.only_rises || !body.on_lift || body.turning_mm > 0) return false;
  if (apart(scene, head, standing, stage.lowest_start, stage.lowest_start, 0)) return false;
  return apart(scene, head, standing, stage.end_low, stage.end_high, margin_mm);
}

/// A pair that the positions of a stage do not keep apart.
std::optional<motion::PairMargin> meets(const motion::Scene& scene, const Stage& stage,
                                        const motion::Margins& margins) {
  for (std::size_t i = 0; i < scene.head().size(); ++i)
    for (std::size_t k = 0; k < scene.standing().size(); ++k) {
      const double margin = margins.of(i, k);
      if (!apart(scene, i, k, stage.low, stage.high, margin) && !only_leaves(scene, stage, i, k, margin))
        return motion::PairMargin{i, k, margin};
    }
  return std::nullopt;
}

/// What is near when a stage begins may be as near. What would overlap there is a place where the lift does not stand,
/// and of what turns nothing is known where nobody knows how C stands.
Result<motion::Margins> margins_of(const Surroundings& around, const Stage& stage) {
  const motion::Scene& scene = around.scene();
  const motion::PathRules rules = around.no_nearer_than(stage.lowest_start);
  auto margins = motion::make_margins(scene, rules.clearance_mm, rules.approaches);
  if (margins && stage.lift_unknown)
    std::erase_if(margins->pairs, [&](const motion::PairMargin& pair) {
      return pair.clearance_mm < 0 && scene.head()[pair.head].on_lift;
    });
  if (margins && stage.turn_unknown)
    std::erase_if(margins->pairs,
                  [&](const motion::PairMargin& pair) { return scene.head()[pair.head].turning_mm > 0; });
  return margins;
}

std::string names(const config::Machine& machine, std::uint32_t mask, const char* between) {
  std::string out;
  for (const config::Axis& axis : machine.axes)
    if ((mask >> axis.id.value & 1u) != 0) out += (out.empty() ? "" : between) + axis.name;
  return out;
}

/// Which axes of an order home, from where to where, and where those stand that do not.
Stage stage_of(const config::Machine& machine, const AxisVec& now, std::uint32_t known, std::uint32_t homing) {
  Stage stage{.low = now, .high = now, .lowest_start = now};
  const auto bit = [](AxisId id) { return 1u << id.value; };
  for (const config::Axis& axis : machine.axes) {
    const std::size_t i = axis.id.value;
    if (!homes(axis)) continue;
    const bool placed = (known & bit(axis.id)) != 0;
    if (placed && (homing & bit(axis.id)) == 0) continue;
    const HomingRange range = placed ? homing_range(axis, now[i]) : homing_range(axis);
    stage.low[i] = range.low, stage.high[i] = range.high;
  }
  stage.end_low = stage.low, stage.end_high = stage.high;
  stage.turn_unknown = machine.c && (known & bit(*machine.c)) == 0;
  if (!machine.u || (known & bit(*machine.u)) != 0) return stage;
  const std::size_t u = machine.u->value, z = machine.z.value;
  stage.lift_unknown = true;
  stage.lowest_start[u] = stage.high[u];
  const bool z_homes = (homing & bit(machine.z)) != 0, u_homes = (homing & bit(*machine.u)) != 0;
  if ((homing & (bit(machine.x) | bit(machine.y))) != 0 || (z_homes && u_homes)) return stage;
  if (z_homes) {
    const config::Homing& h = *machine.axes[z].homing;
    stage.only_rises = one_way(h.method) && now[z] < h.position - beyond(h);
    stage.end_low[z] = stage.end_high[z], stage.end_low[u] = stage.end_high[u] = stage.low[u];
  } else if (u_homes) {
    const config::Homing& h = *machine.axes[u].homing;
    stage.only_rises = one_way(h.method) && h.position <= machine.axes[u].p_min;
    stage.end_high[u] = h.position + beyond(h);
  }
  return stage;
}

Result<void> prove(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                   const HomingAxes& axes) {
  const motion::Scene& scene = around.scene();
  std::set<int> orders;
  for (const config::Axis& axis : machine.axes)
    if (homes(axis)) orders.insert(axis.homing->order);
  AxisVec now = at;
  std::uint32_t known = axes.referenced;
  for (const int order : orders) {
    std::uint32_t homing = 0;
    for (const config::Axis& axis : machine.axes)
      if (homes(axis) && axis.homing->order == order) homing |= axes.homed & 1u << axis.id.value;
    if (homing == 0) continue;
    const Stage stage = stage_of(machine, now, known, homing);
    const auto margins = margins_of(around, stage);
    if (!margins) return tl::unexpected(margins.error());
    if (const auto met = meets(scene, stage, *margins))
      return fail(Fault::Collision,
                  fmt::format("while {} home, {} could come within {:.3g} mm of {}", names(machine, homing, ", "),
                              scene.head()[met->head].name, met->clearance_mm, scene.standing()[met->standing].name));
    for (const config::Axis& axis : machine.axes) {
      const std::uint32_t bit = 1u << axis.id.value;
      if ((homing & bit) != 0 && (!stays(axis.homing->method) || (known & bit) == 0))
        now[axis.id.value] = axis.homing->position;
    }
    known |= homing;
  }
  return {};
}

}  // namespace

HomingRange homing_range(const config::Axis& axis, double at) {
  const config::Homing& h = *axis.homing;
  if (stays(h.method)) return {at, at};
  const HomingRange range{std::min(at, h.position - beyond(h)), std::max(at, h.position + beyond(h))};
  if (one_way(h.method)) return range;
  return {std::min(range.low, axis.p_min - beyond(h)), std::max(range.high, axis.p_max + beyond(h))};
}

HomingRange homing_range(const config::Axis& axis) {
  const config::Homing& h = *axis.homing;
  return {std::min(axis.p_min, h.position) - beyond(h), std::max(axis.p_max, h.position) + beyond(h)};
}

bool head_is_placed(const config::Machine& machine, std::uint32_t referenced) {
  const std::uint32_t head = 1u << machine.x.value | 1u << machine.y.value | 1u << machine.z.value;
  return (referenced & head) == head;
}

Result<void> prove_homing(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                          const HomingAxes& axes) {
  auto proof = prove(machine, around, at, axes);
  if (proof) return proof;
  std::uint32_t lost = 0;
  for (const config::Axis& axis : machine.axes)
    if (homes(axis)) lost |= ~axes.referenced & 1u << axis.id.value;
  std::string remedy = "park the head, or jog it clear of that, and home then";
  if (lost != 0 && lost != axes.homed && prove(machine, around, at, {axes.referenced, lost}))
    remedy =
        fmt::format("home {} alone first, which is proved (`gantry home {}`); then home, or jog the head clear of that",
                    names(machine, lost, ", "), names(machine, lost, " "));
  else if (lost != 0)
    remedy = fmt::format(
        "{} {} not referenced, so that no jog is proved either: without torque, move the head clear "
        "of that by hand",
        names(machine, lost, ", "), std::has_single_bit(lost) ? "is" : "are");
  Error why = proof.error();
  why.message += "; " + remedy;
  return tl::unexpected(std::move(why));
}

}  // namespace gantry::job
