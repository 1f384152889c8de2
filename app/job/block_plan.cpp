#include "app/job/block_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "app/job/limits.hpp"
#include "app/job/settle.hpp"
#include "app/job/surroundings.hpp"
#include "motion/path/bead.hpp"

namespace gantry::job {
namespace {

constexpr double kTriggerPulse_s = 0.010;
constexpr double kNone = 1e9;  // gap before the first feature

/// That a plan was given up is nothing about the recipe.
Error with_line(Error e, const recipes::Recipe& recipe, recipes::Place location, std::string_view what) {
  if (e.fault == Fault::Aborted) return e;
  e.message = fmt::format("{}: {}", what, e.message);
  e.where = at_line(recipe, location);
  return e;
}

/// Where the recipe asks for the last work of a job: parking goes away from there.
recipes::Place last_place(const recipes::Recipe& recipe) {
  if (!recipe.features.empty()) return std::visit([](const auto& f) { return f.place; }, recipe.features.back());
  if (!recipe.touches.empty()) return recipe.touches.back().place;
  return recipe.marks.empty() ? recipes::Place{1, 1} : recipe.marks.back().place;
}

}  // namespace

BlockPlanner::BlockPlanner(const config::Machine& machine, const recipes::Recipe& recipe, Breath breath)
    : machine_(machine),
      recipe_(recipe),
      breath_(std::move(breath)),
      limits_(limits_of(machine)),
      surroundings_(std::make_shared<Surroundings>(machine, recipe, unmeasured(recipe))) {}

BlockPlanner::~BlockPlanner() = default;

void BlockPlanner::know(const Knowledge& known) {
  const bool moved = known.offset != known_.offset || known.surface != known_.surface;
  known_ = known;
  if (moved) surroundings_ = std::make_shared<Surroundings>(machine_, recipe_, belief_of(recipe_, known));
}

BlockBuilder BlockPlanner::build(std::uint32_t block, const AxisVec& from) const {
  return {limits_, surroundings_->scene(), block, from, breath_};
}

Vec3 BlockPlanner::mark_view(std::size_t mark) const {
  return recipes::to_machine(recipe_, machine_, known_.guess, {}, recipe_.marks[mark].at, 0);
}

Subject BlockPlanner::subject(std::string_view kind, const std::string& name, recipes::Place place) const {
  return {kind, name, recipe_.file, place};
}

Result<ProvenBlock> BlockPlanner::look_at_mark(std::uint32_t block, const AxisVec& from, std::size_t mark) const {
  const recipes::MarkDef& def = recipe_.marks[mark];
  const config::Tool& camera = *config::find_tool(machine_, "camera");
  BlockBuilder builder = build(block, from);
  builder.about(subject("mark", def.name, def.place));
  const AxisVec to = recipes::tool_at(machine_, camera, mark_view(mark), 0);
  if (auto r = builder.travel(to, surroundings_->travelling(from)); !r)
    return tl::unexpected(with_line(r.error(), recipe_, def.place, fmt::format("mark '{}'", def.name)));

  const std::uint32_t light = config::bit(config::Output::CameraLight),
                      trigger = config::bit(config::Output::CameraTrigger);
  const double settle_s = machine_.camera.expose_after_ticks * limits_.tick_s;
  const std::array expose{motion::OutputEvent{.at_s = 0, .mask = light, .value = light},
                          motion::OutputEvent{.at_s = settle_s, .mask = trigger, .value = trigger}};
  const std::array after{motion::OutputEvent{.at_s = kTriggerPulse_s / 2, .mask = light | trigger, .value = 0}};
  builder.dwell(settle_s + limits_.tick_s, expose);
  builder.dwell(kTriggerPulse_s, after);
  return builder.finish();
}

/// The probe's tip over a touch point, so high above the nominal surface.
AxisVec BlockPlanner::probe_at(std::size_t touch, double height_mm) const {
  const config::Tool& probe = *config::find_tool(machine_, "probe");
  const Vec3 at = recipes::to_machine(recipe_, machine_, offset(), {}, recipe_.touches[touch].at, height_mm);
  return recipes::tool_at(machine_, probe, at, 0);
}

Result<ProvenBlock> BlockPlanner::touch(std::uint32_t block, const AxisVec& from, std::size_t index) const {
  const recipes::TouchPoint& point = recipe_.touches[index];
  const double window = recipe_.touch_rules.window_mm;
  const auto wrong = [&](const Error& e) {
    return tl::unexpected(with_line(e, recipe_, point.place, fmt::format("touch '{}'", point.name)));
  };
  BlockBuilder builder = build(block, from);
  builder.about(subject("touch", point.name, point.place));
  const double approach = machine_.probe.approach_mm;
  if (auto r = builder.travel(probe_at(index, window + approach), surroundings_->approaching(from, approach)); !r)
    return wrong(r.error());
  builder.among(surroundings_->scene_of_touch());
  const double speed = machine_.probe.fast_mm_s > 0 ? machine_.probe.fast_mm_s : machine_.probe.speed_mm_s;
  if (auto r = builder.until_probe(probe_at(index, -window), surroundings_->touching(window), speed); !r)
    return wrong(r.error());
  return builder.finish();
}

Result<ProvenBlock> BlockPlanner::touch_again(std::uint32_t block, const AxisVec& from, std::size_t index) const {
  const recipes::TouchPoint& point = recipe_.touches[index];
  const double window = recipe_.touch_rules.window_mm;
  BlockBuilder builder = build(block, from);
  builder.about(subject("touch", point.name, point.place));
  builder.among(surroundings_->scene_of_touch());
  if (auto r =
          builder.until_probe(probe_at(index, -window), surroundings_->touching(window), machine_.probe.speed_mm_s);
      !r)
    return tl::unexpected(with_line(r.error(), recipe_, point.place, fmt::format("second touch '{}'", point.name)));
  return builder.finish();
}

Result<ProvenBlock> BlockPlanner::back_off(std::uint32_t block, const AxisVec& from, std::size_t index) const {
  return up(block, from, index, machine_.probe.back_off_mm);
}

Result<ProvenBlock> BlockPlanner::retract(std::uint32_t block, const AxisVec& from, std::size_t index) const {
  return up(block, from, index, machine_.probe.retract_mm);
}

Result<ProvenBlock> BlockPlanner::up(std::uint32_t block, const AxisVec& from, std::size_t index, double by_mm) const {
  const recipes::TouchPoint& point = recipe_.touches[index];
  BlockBuilder builder = build(block, from);
  builder.about(subject("touch", point.name, point.place));
  builder.among(surroundings_->scene_of_touch());
  AxisVec to = from;
  double& z = to[machine_.z.value];
  z = std::min(z + by_mm, limits_.axis[machine_.z.value].p_max);
  if (auto r = builder.straight(to, surroundings_->touching(recipe_.touch_rules.window_mm)); !r)
    return tl::unexpected(with_line(r.error(), recipe_, point.place, fmt::format("up from touch '{}'", point.name)));
  return builder.finish();
}

Result<ProvenBlock> BlockPlanner::dispense(std::uint32_t block, const AxisVec& from,
                                           const std::vector<std::size_t>& features) const {
  BlockBuilder builder = build(block, from);
  double gap_mm = kNone;  // of the last feature: the needle stands so near to the board, lifted or not
  for (const std::size_t f : features) {
    if (!go_on(breath_)) return given_up();
    const recipes::Feature& feature = recipe_.features[f];
    const auto dispensed = std::holds_alternative<recipes::Dot>(feature)
                               ? add_dot(builder, std::get<recipes::Dot>(feature), f, gap_mm)
                               : add_bead(builder, std::get<recipes::Bead>(feature), f, gap_mm);
    if (!dispensed) return tl::unexpected(dispensed.error());
  }
  return builder.finish();
}

/// From feature to feature the needle stays as near to the board as the nearer of them; to the first one it comes from
/// elsewhere.
motion::PathRules BlockPlanner::on_the_way(const BlockBuilder& builder, double last_gap_mm, double gap_mm) const {
  motion::PathRules rules = surroundings_->dispensing(std::min(last_gap_mm, gap_mm));
  if (last_gap_mm != kNone) return rules;
  motion::PathRules from = surroundings_->travelling(builder.at());
  rules.approaches.insert(rules.approaches.end(), from.approaches.begin(), from.approaches.end());
  return rules;
}

AxisVec BlockPlanner::needle_at(Vec2 at, double height_mm) const {
  return recipes::tool_at(machine_, *config::find_tool(machine_, "needle"),
                          recipes::to_machine(recipe_, machine_, offset(), surface(), at, height_mm),
                          offset().rotation);
}

/// The same position, higher by the material's retract.
AxisVec BlockPlanner::lifted(AxisVec q, const recipes::Material& material) const {
  q[machine_.z.value] = std::min(q[machine_.z.value] + material.retract, limits_.axis[machine_.z.value].p_max);
  return q;
}

Result<void> BlockPlanner::add_dot(BlockBuilder& builder, const recipes::Dot& dot, std::size_t index,
                                   double& gap_mm) const {
  const recipes::Material& m = *recipes::find_material(recipe_, dot.material);
  builder.about(subject("dot", dot.id, dot.place));
  const motion::PathRules rules = surroundings_->dispensing(m.gap);
  const AxisVec to = needle_at(dot.at, m.gap);
  Result<void> done = builder.travel(lifted(to, m), on_the_way(builder, gap_mm, m.gap));
  gap_mm = m.gap;
  if (done) done = builder.straight(to, rules);
  if (done) {
    const std::uint32_t valve = config::bit(config::Output::Valve);
    const std::array events{
        motion::OutputEvent{
            .at_s = m.settle_time, .lead_s = m.valve_open_lead, .mask = valve, .value = valve, .dispense = true},
        motion::OutputEvent{
            .at_s = m.settle_time + m.dot_time, .lead_s = m.valve_close_lead, .mask = valve, .value = 0}};
    builder.dwell(m.settle_time + m.dot_time, events, static_cast<std::uint32_t>(index));
    done = builder.straight(lifted(to, m), rules);
  }
  if (!done) return tl::unexpected(with_line(done.error(), recipe_, dot.place, fmt::format("dot '{}'", dot.id)));
  return {};
}

Result<void> BlockPlanner::add_bead(BlockBuilder& builder, const recipes::Bead& bead, std::size_t index,
                                    double& gap_mm) const {
  const recipes::Material& m = *recipes::find_material(recipe_, bead.material);
  builder.about(subject("bead", bead.id, bead.place));
  const motion::PathRules rules = surroundings_->dispensing(m.gap);
  const auto wrong = [&](const Error& e) {
    return tl::unexpected(with_line(e, recipe_, bead.place, fmt::format("bead '{}'", bead.id)));
  };
  motion::BeadSpec spec;
  for (const Vec2 p : bead.points) spec.points.push_back(needle_at(p, m.gap));
  spec.speed_mm_s = m.speed;
  spec.corner_tolerance_mm = bead.corner_tolerance;
  spec.valve = config::bit(config::Output::Valve);
  spec.open_lead_s = m.valve_open_lead;
  spec.close_lead_s = m.valve_close_lead;
  auto planned = motion::plan_bead(limits_, spec);
  if (!planned) return wrong(planned.error());

  if (auto r = builder.travel(lifted(planned->start, m), on_the_way(builder, gap_mm, m.gap)); !r)
    return wrong(r.error());
  gap_mm = m.gap;
  if (auto r = builder.straight(planned->start, rules); !r) return wrong(r.error());
  if (auto r = builder.bead(*planned, rules, static_cast<std::uint32_t>(index)); !r) return wrong(r.error());
  if (auto r = builder.straight(lifted(planned->end, m), rules); !r) return wrong(r.error());
  return {};
}

Result<ProvenBlock> BlockPlanner::park(std::uint32_t block, const AxisVec& from) const {
  BlockBuilder builder = build(block, from);
  const recipes::Place last = last_place(recipe_);
  builder.about({"the park position", "", recipe_.file, last});
  AxisVec to = from;
  for (const auto& [axis, position] : machine_.park) to[axis.value] = position;
  if (auto r = builder.travel(to, surroundings_->travelling(from)); !r)
    return tl::unexpected(with_line(r.error(), recipe_, last, "parking"));
  return builder.finish();
}

}  // namespace gantry::job
