#include "app/job/block_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <utility>

#include "app/job/level.hpp"
#include "app/job/limits.hpp"
#include "app/job/park.hpp"
#include "app/job/settle.hpp"
#include "app/job/surroundings.hpp"
#include "motion/path/bead.hpp"
#include "motion/path/chords.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::job {
namespace {

constexpr double kTriggerPulse_s = 0.010;
constexpr double kOverLaid = 2;         // gaps above the bead's own, where the run-up of a joined bead begins
constexpr double kAlone = 0.5;          // of the material's retract: within it nothing moves but up and down
constexpr double kBackTrack_mm = 0.05;  // back over a bead the needle stays as near to it as this
constexpr double kEachOfBack = 0.3;  // of that, for the points that it leaves out, and for the rounding of its corners
constexpr int kSlowerBack = 10;      // times half of the speed are tried for it

/// That a plan was given up is nothing about the recipe.
Error with_line(Error e, const recipes::Recipe& recipe, recipes::Location location, std::string_view what) {
  if (e.fault == Fault::Aborted) return e;
  e.message = fmt::format("{}: {}", what, e.message);
  e.where = at_line(recipe, location);
  return e;
}

/// Where the recipe asks for the last work of a job: parking goes away from there.
recipes::Location last_location(const recipes::Recipe& recipe) {
  if (!recipe.features.empty())
    return std::visit([](const auto& f) { return f.location; }, recipe.features[recipes::sequence_of(recipe).back()]);
  if (!recipe.touches.empty()) return recipe.touches.back().location;
  return recipe.marks.empty() ? recipes::Location{1, 1} : recipe.marks.back().location;
}

recipes::Location location_of(const recipes::Feature& feature) {
  return std::visit([](const auto& f) { return f.location; }, feature);
}

/// "dot 'a'"
std::string words_of(const recipes::Feature& feature) {
  return fmt::format("{} '{}'", std::holds_alternative<recipes::Dot>(feature) ? "dot" : "bead",
                     recipes::id_of(feature));
}

/// How far corners may be rounded. In space that changes the gap, the more the steeper the bead is: it stays within its
/// tolerance, and the needle above what it dispenses on.
double rounding_mm(const recipes::Bead& bead, const recipes::Material& m) {
  constexpr double kSteepest = 0.3;  // cosine; beyond it a bead goes beside a wall rather than over a surface
  if (is_level(bead)) return bead.corner_tolerance;
  double level = 1;
  for (std::size_t i = 1; i < bead.points.size(); ++i) {
    const Vec3 leg = bead.points[i] - bead.points[i - 1];
    if (norm(leg) > 0) level = std::min(level, norm(flat(leg)) / norm(leg));
  }
  return recipes::upright_tolerance_mm(bead.corner_tolerance, m) * std::max(level, kSteepest);
}

/// The command that shuts the valve moves back along the bead.
void shut_early(motion::BeadMotion& bead, double early_mm) {
  if (early_mm <= 0) return;
  const auto shuts = [](const motion::OutputEvent& e) { return e.mask != 0 && e.value == 0; };
  auto from = std::find_if(bead.segments.rbegin(), bead.segments.rend(), [&](const motion::Segment& s) {
    return std::any_of(s.events.begin(), s.events.end(), shuts);
  });
  if (from == bead.segments.rend()) return;
  const auto events = std::exchange(from->events, {});
  motion::OutputEvent shut;
  for (const motion::OutputEvent& e : events)
    if (shuts(e))
      shut = e;
    else
      from->events.push_back(e);
  double s = shut.at_s - early_mm;
  const auto may_go_back = [&] {
    return std::next(from) != bead.segments.rend() && std::next(from)->kind == motion::SegmentKind::Piece;
  };
  for (; s < 0 && may_go_back(); ++from) s += std::next(from)->geometry.length;
  shut.at_s = std::max(0.0, s);
  from->events.push_back(shut);
}

}  // namespace

BlockPlanner::BlockPlanner(const config::Machine& machine, const recipes::Recipe& recipe, Breath breath,
                           motion::Opinion opinion)
    : machine_(machine),
      recipe_(recipe),
      breath_(std::move(breath)),
      opinion_(std::move(opinion)),
      limits_(limits_of(machine)) {}

BlockPlanner::~BlockPlanner() = default;

void BlockPlanner::know(const Knowledge& known) {
  const bool moved = known.offset != known_.offset || known.surface != known_.surface;
  known_ = known;
  if (moved) surroundings_.reset();
}

void BlockPlanner::share(const BlockPlanner& other) {
  if (!surroundings_ && known_.offset == other.known_.offset && known_.surface == other.known_.surface)
    surroundings_ = other.surroundings_;
}

const std::shared_ptr<const Surroundings>& BlockPlanner::surroundings() const {
  if (!surroundings_)
    surroundings_ = std::make_shared<Surroundings>(machine_, recipe_, belief_of(machine_, recipe_, known_));
  return surroundings_;
}

BlockBuilder BlockPlanner::build(std::uint32_t block, const AxisVec& from) const {
  BlockBuilder builder(limits_, surroundings()->scene(), block, from, breath_, opinion_);
  builder.list(rows());
  builder.ways(known_ways_.get(), kept_ways_.get());
  return builder;
}

Vec3 BlockPlanner::mark_view(std::size_t mark) const {
  return recipes::to_machine(recipe_, machine_, known_.guess, {}, recipe_.marks[mark].at, 0);
}

Subject BlockPlanner::subject(std::string_view kind, const std::string& name, recipes::Location location) const {
  return {kind, name, recipe_.file, location};
}

Result<ProvenBlock> BlockPlanner::look_at_mark(std::uint32_t block, const AxisVec& from, std::size_t mark) const {
  const recipes::MarkDef& def = recipe_.marks[mark];
  const config::Tool& camera = *config::find_tool(machine_, "camera");
  BlockBuilder builder = build(block, from);
  builder.about(subject("mark", def.name, def.location));
  const AxisVec to = recipes::tool_at(machine_, camera, mark_view(mark), 0);
  if (auto r = builder.travel(to, surroundings()->travelling(from)); !r)
    return tl::unexpected(with_line(r.error(), recipe_, def.location, fmt::format("mark '{}'", def.name)));

  const std::uint32_t light = config::bit(config::Output::CameraLight),
                      trigger = config::bit(config::Output::CameraTrigger);
  const double settle_s = machine_.camera.expose_after_ticks * limits_.tick_s;
  const std::array expose{motion::OutputEvent{.at_s = 0, .mask = light, .value = light},
                          motion::OutputEvent{.at_s = settle_s, .mask = trigger, .value = trigger}};
  const std::array after{motion::OutputEvent{.at_s = kTriggerPulse_s / 2, .mask = light | trigger, .value = 0}};
  for (const auto& [seconds, events] :
       {std::pair(settle_s + limits_.tick_s, std::span<const motion::OutputEvent>(expose)),
        std::pair(kTriggerPulse_s, std::span<const motion::OutputEvent>(after))})
    if (auto r = builder.dwell(seconds, events); !r)
      return tl::unexpected(with_line(r.error(), recipe_, def.location, fmt::format("mark '{}'", def.name)));
  return builder.finish();
}

AxisVec BlockPlanner::probe_at(std::size_t touch, double height_mm) const {
  const config::Tool& probe = *config::find_tool(machine_, "probe");
  const Vec3 at = recipes::to_machine(recipe_, machine_, offset(), {}, recipe_.touches[touch].at, height_mm);
  return recipes::tool_at(machine_, probe, at, 0);
}

Result<ProvenBlock> BlockPlanner::touch(std::uint32_t block, const AxisVec& from, std::size_t index) const {
  const recipes::TouchPoint& point = recipe_.touches[index];
  BlockBuilder builder = build(block, from);
  builder.about(subject("touch", point.name, point.location));
  const double approach = machine_.probe.approach_mm;
  const AxisVec above = probe_at(index, recipe_.touch_rules.window_mm + approach);
  const std::string words = fmt::format("touch '{}'", point.name);
  if (auto r = builder.travel(above, surroundings()->approaching(from, approach)); !r)
    return tl::unexpected(with_line(r.error(), recipe_, point.location, words));
  const double fast = machine_.probe.fast_mm_s;
  return down(std::move(builder), index, fast > 0 ? fast : machine_.probe.speed_mm_s, words);
}

Result<ProvenBlock> BlockPlanner::touch_again(std::uint32_t block, const AxisVec& from, std::size_t index) const {
  const recipes::TouchPoint& point = recipe_.touches[index];
  BlockBuilder builder = build(block, from);
  builder.about(subject("touch", point.name, point.location));
  return down(std::move(builder), index, machine_.probe.speed_mm_s, fmt::format("second touch '{}'", point.name));
}

Result<ProvenBlock> BlockPlanner::down(BlockBuilder builder, std::size_t index, double speed_mm_s,
                                       const std::string& words) const {
  const double window = recipe_.touch_rules.window_mm;
  builder.among(surroundings()->scene_of_touch());
  if (auto r = builder.until_probe(probe_at(index, -window), surroundings()->touching(window), speed_mm_s); !r)
    return tl::unexpected(with_line(r.error(), recipe_, recipe_.touches[index].location, words));
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
  builder.about(subject("touch", point.name, point.location));
  builder.among(surroundings()->scene_of_touch());
  AxisVec to = from;
  rise(to, by_mm);
  if (auto r = builder.straight(to, surroundings()->touching(recipe_.touch_rules.window_mm)); !r)
    return tl::unexpected(with_line(r.error(), recipe_, point.location, fmt::format("up from touch '{}'", point.name)));
  return builder.finish();
}

Result<ProvenBlock> BlockPlanner::purge(std::uint32_t block, const AxisVec& from) const {
  const recipes::Purge& purge = *recipe_.purge;
  const recipes::Material& m = *recipes::find_material(recipe_, purge.material);
  BlockBuilder builder = build(block, from);
  builder.about(subject("the purge place", "", purge.at_location));
  const bool on_board = purge.frame.empty();
  const AxisVec to = recipes::tool_at(machine_, *config::find_tool(machine_, "needle"),
                                      recipes::purge_tip(recipe_, machine_, offset(), surface()), offset().rotation);
  const motion::PathRules on_travel =
      on_board ? travel_rules(builder, lifted(to, m), {}, work_of(m, "")) : surroundings()->travelling(from);
  const motion::PathRules there =
      on_board ? surroundings()->dispensing({work_of(m, "")}) : surroundings()->travelling(lifted(to, m));
  Result<void> done = builder.travel(lifted(to, m), on_travel);
  if (done) done = builder.vertical(to, there, m.retract * kAlone);
  if (done) {
    const std::uint32_t valve = config::bit(config::Output::Valve);
    // The valve is told to open after it was told to close.
    const double pause_s = m.settle_time + m.valve_open_lead;
    const std::array shot{
        motion::OutputEvent{
            .at_s = pause_s, .lead_s = m.valve_open_lead, .mask = valve, .value = valve, .dispense = true},
        motion::OutputEvent{.at_s = pause_s + m.dot_time, .lead_s = m.valve_close_lead, .mask = valve, .value = 0}};
    for (int i = 0; done && i < purge.shots; ++i) done = builder.dwell(pause_s + m.dot_time, shot);
    if (done) done = builder.vertical(lifted(to, m), there, m.retract * kAlone);
  }
  if (!done) return tl::unexpected(with_line(done.error(), recipe_, purge.at_location, "purging"));
  auto planned = builder.finish();
  if (!planned) return tl::unexpected(with_line(planned.error(), recipe_, purge.at_location, "purging"));
  return over_board(*std::move(planned), "purging", purge.at_location);
}

Result<ProvenBlock> BlockPlanner::dispense(std::uint32_t block, const AxisVec& from,
                                           const std::vector<std::size_t>& features,
                                           const std::vector<LaidPart>& laid) const {
  BlockBuilder builder = build(block, from);
  std::optional<Work> last;  // the needle stands so near to it, lifted or not
  for (const std::size_t f : features) {
    if (!go_on(breath_)) return given_up();
    if (count_) count_();
    const recipes::Feature& feature = recipe_.features[f];
    if (const auto& doubt = surroundings()->doubt())
      if (const auto why = recipes::reaches_board(recipe_, *doubt, feature))
        return tl::unexpected(
            with_line({Fault::Collision, *why, {}}, recipe_, location_of(feature), words_of(feature)));
    const auto dispensed = std::holds_alternative<recipes::Dot>(feature)
                               ? add_dot(builder, std::get<recipes::Dot>(feature), f, last)
                               : add_bead(builder, std::get<recipes::Bead>(feature), laid_of(laid, f), last);
    if (!dispensed) return tl::unexpected(dispensed.error());
  }
  auto planned = builder.finish();
  if (features.empty()) return planned;
  const recipes::Feature& last_one = recipe_.features[features.back()];
  if (!planned)
    return tl::unexpected(with_line(planned.error(), recipe_, location_of(last_one),
                                    fmt::format("up from '{}'", recipes::id_of(last_one))));
  return over_board(*std::move(planned), words_of(last_one), location_of(last_one));
}

/// Told of the feature that is dispensed next, or by the words that are given.
Result<ProvenBlock> BlockPlanner::over_board(ProvenBlock block, std::string words, recipes::Location location) const {
  const auto low = surroundings()->below_board(block.segments(), breath_);
  if (!low) return block;
  for (std::size_t i = low->segment; i < block.segments().size(); ++i)
    if (const std::uint32_t f = block.segments()[i].feature; f != motion::kTravel) {
      words = words_of(recipe_.features[f]), location = location_of(recipe_.features[f]);
      break;
    }
  return tl::unexpected(
      with_line({Fault::Collision,
                 fmt::format("{} comes within 0 mm of {} at {}: the board's face, which is measured where it was "
                             "touched, may be {:.3f} mm higher there",
                             low->body, kBoard, low->at, low->by_mm),
                 {}},
                recipe_, location, words));
}

Result<ProvenBlock> BlockPlanner::lift(std::uint32_t block, const AxisVec& from, std::size_t feature) const {
  return std::visit(
      [&](const auto& f) -> Result<ProvenBlock> {
        const recipes::Material& m = *recipes::find_material(recipe_, f.material);
        BlockBuilder builder = build(block, from);
        builder.about(subject("feature", f.id, f.location));
        Work work;
        if constexpr (std::is_same_v<std::decay_t<decltype(f)>, recipes::Bead>)
          work = work_of(f);
        else
          work = work_of(m, f.on);
        if (auto r = builder.dwell(m.valve_close_lead); !r) return tl::unexpected(r.error());  // it flows until then
        if (auto r = builder.straight(lifted(from, m), surroundings()->dispensing({work})); !r)
          return tl::unexpected(with_line(r.error(), recipe_, f.location, fmt::format("up from '{}'", f.id)));
        auto planned = builder.finish();
        if (!planned) return planned;
        return over_board(*std::move(planned), fmt::format("up from '{}'", f.id), f.location);
      },
      recipe_.features[feature]);
}

Work BlockPlanner::work_of(const recipes::Bead& bead) const {
  const recipes::Material& m = *recipes::find_material(recipe_, bead.material);
  Work work = work_of(m, bead.on);
  if (!is_level(bead)) work.cut_mm = rounding_mm(bead, m);
  return work;
}

Work BlockPlanner::work_of(const recipes::Material& material, const std::string& on) const {
  Work work{.gap_mm = material.gap, .alone_mm = material.retract * kAlone};
  for (const recipes::Part& part : recipe_.parts)
    if (!part.fixture && part.name == on) work.on = on, work.top_mm = part.size.z;
  return work;
}

/// From feature to feature the needle stays as near to what they lie on as the nearer of them; to the first one it
/// comes from elsewhere. A path that has to turn aside leads over what is dispensed already.
motion::PathRules BlockPlanner::travel_rules(const BlockBuilder& builder, const AxisVec& to,
                                             const std::optional<Work>& last, const Work& work) const {
  const std::size_t z = machine_.z.value;
  motion::PathRules rules = surroundings()->dispensing(last ? std::vector{*last, work} : std::vector{work});
  rules.lowest_mm = std::min(builder.at()[z] - (last ? last->alone_mm : 0), to[z] - work.alone_mm);
  if (last) return rules;
  motion::PathRules from = surroundings()->travelling(builder.at());
  rules.approaches.insert(rules.approaches.end(), from.approaches.begin(), from.approaches.end());
  return rules;
}

/// Over the next work, by a path that is free. Where it turns out of the motion up and into the motion down, the needle
/// is higher over both works by what it goes alone there.
Result<void> BlockPlanner::go_over(BlockBuilder& builder, const AxisVec& to, const std::optional<Work>& last,
                                   const Work& work) const {
  const auto higher = [](Work w) { return w.gap_mm += w.alone_mm, w; };
  return builder.travel(to, travel_rules(builder, to, last, work),
                        travel_rules(builder, to, last ? std::optional(higher(*last)) : std::nullopt, higher(work)));
}

AxisVec BlockPlanner::needle_at(Vec2 at, double height_mm) const {
  return recipes::tool_at(machine_, *config::find_tool(machine_, "needle"),
                          recipes::to_machine(recipe_, machine_, offset(), surface(), at, height_mm),
                          offset().rotation);
}

/// Within this of its end, mm, nothing but the descent goes on: half of retract, or more, so that the valve is told to
/// open on it. `after_s`: from the end of the descent to the moment that the lead counts from.
double BlockPlanner::straight_down_mm(const AxisVec& to, const recipes::Material& m, double after_s) const {
  const double alone_mm = m.retract * kAlone, before_s = m.valve_open_lead - after_s + limits_.tick_s;
  if (before_s <= 0) return alone_mm;
  const std::vector<motion::Segment> down = motion::line_move(limits_, lifted(to, m), to);
  if (down.empty()) return alone_mm;
  const motion::Segment& line = down.front();
  const double gone_mm = motion::along(line.nominal, std::max(0.0, motion::duration(down) - before_s)).x.p;
  return std::max(alone_mm, line.geometry.length - gone_mm);
}

/// Up, and no farther than the axis goes.
void BlockPlanner::rise(AxisVec& q, double mm) const {
  double& z = q[machine_.z.value];
  z = std::min(z + mm, limits_.axis[machine_.z.value].p_max);
}

/// The same position, higher by the material's retract.
AxisVec BlockPlanner::lifted(AxisVec q, const recipes::Material& material) const {
  rise(q, material.retract);
  return q;
}

Result<void> BlockPlanner::add_dot(BlockBuilder& builder, const recipes::Dot& dot, std::size_t index,
                                   std::optional<Work>& last) const {
  const recipes::Material& m = *recipes::find_material(recipe_, dot.material);
  const Work work = work_of(m, dot.on);
  builder.about(subject("dot", dot.id, dot.location));
  const motion::PathRules rules = surroundings()->dispensing({work});
  const AxisVec to = needle_at(dot.at, dot.height_mm + m.gap);
  Result<void> done = go_over(builder, lifted(to, m), last, work);
  last = work;
  if (done) done = builder.vertical(to, rules, straight_down_mm(to, m, m.settle_time));
  if (done) {
    const std::uint32_t valve = config::bit(config::Output::Valve);
    const std::array events{
        motion::OutputEvent{
            .at_s = m.settle_time, .lead_s = m.valve_open_lead, .mask = valve, .value = valve, .dispense = true},
        motion::OutputEvent{
            .at_s = m.settle_time + m.dot_time, .lead_s = m.valve_close_lead, .mask = valve, .value = 0}};
    done = builder.dwell(m.settle_time + m.dot_time, events, static_cast<std::uint32_t>(index));
    if (done) done = builder.vertical(lifted(to, m), rules, work.alone_mm);
  }
  if (!done) return tl::unexpected(with_line(done.error(), recipe_, dot.location, fmt::format("dot '{}'", dot.id)));
  return {};
}

Result<void> BlockPlanner::add_bead(BlockBuilder& builder, const recipes::Bead& bead, const LaidPart& laid,
                                    std::optional<Work>& last) const {
  const recipes::Material& m = *recipes::find_material(recipe_, bead.material);
  const Work work = work_of(bead);
  builder.about(subject("bead", bead.id, bead.location));
  const motion::PathRules rules = surroundings()->dispensing({work});
  const auto wrong = [&](const Error& e) {
    return tl::unexpected(with_line(e, recipe_, bead.location, fmt::format("bead '{}'", bead.id)));
  };
  motion::BeadSpec spec;
  for (const Vec3 p : bead.points) spec.points.push_back(needle_at(flat(p), p.z + m.gap));
  spec.speed_mm_s = laid.slow_mm_s > 0 ? std::min(m.speed, laid.slow_mm_s) : m.speed;
  spec.corner_tolerance_mm = rounding_mm(bead, m);
  spec.valve = config::bit(config::Output::Valve);
  spec.open_lead_s = m.valve_open_lead;
  spec.close_lead_s = m.valve_close_lead;
  // The run-up onto what lies already begins so high that the needle is above that until it joins it.
  spec.lift_mm = kOverLaid * m.gap;
  spec.lift_axis = machine_.z.value;
  spec.begin_mm = laid.mm;
  if (laid.mm <= 0) spec.stand_s = std::max(0.0, m.start_dwell_s - laid.stood_s);
  auto begun = begin(builder, std::move(spec), m, rules, work);
  if (!begun) return wrong(begun.error());
  motion::BeadMotion& planned = begun->motion;
  begun->how.feature = static_cast<std::uint32_t>(laid.feature);
  shut_early(planned, m.early_off);

  const auto before = [&](Error e) {
    if (e.fault == Fault::Collision && planned.run_up_mm > 0)
      e.message =
          fmt::format("where its run-up starts, {:.3g} mm before its first point: {}; a lower speed needs less of it",
                      planned.run_up_mm, e.message);
    return wrong(e);
  };
  const bool from_above = begun->how.kind == RunUp::Kind::FromAbove;
  if (auto r = go_over(builder, from_above ? planned.start : lifted(planned.start, m), last, work); !r)
    return before(r.error());
  last = work;
  const double run_up_s = motion::duration(std::span(planned.segments).first(planned.bead_begin));
  if (!from_above)
    if (auto r = builder.vertical(planned.start, rules, straight_down_mm(planned.start, m, run_up_s)); !r)
      return before(r.error());
  if (auto r = builder.bead(planned, rules, static_cast<std::uint32_t>(laid.feature)); !r) return wrong(r.error());
  if (auto r = surroundings()->keeps_gap(std::span(planned.segments).subspan(planned.bead_end), work); !r) {
    Error e = r.error();
    e.message = fmt::format("its run-out of {:.3g} mm: {}", planned.run_out_mm, e.message);
    return wrong(e);
  }
  if (begun->how.kind != RunUp::Kind::Whole) builder.begun(std::move(begun->how));
  if (auto r = leave_bead(builder, bead, rules); !r) return wrong(r.error());
  if (auto r = builder.vertical(lifted(builder.at(), m), rules, work.alone_mm); !r) return wrong(r.error());
  return {};
}

/// The descent and the run-up are what has to be free for it, and what the valve opens ahead on.
Result<BegunBead> BlockPlanner::begin(const BlockBuilder& builder, motion::BeadSpec spec, const recipes::Material& m,
                                      const motion::PathRules& rules, const Work& work) const {
  return plan_begin(limits_, std::move(spec), m, [&](const motion::BeadMotion& bead, RunUp::Kind kind) -> Result<void> {
    const std::span run_up = std::span(bead.segments).first(bead.bead_begin);
    double last_s = motion::duration(run_up);
    if (kind != RunUp::Kind::FromAbove) {
      const std::array down{lifted(bead.start, m), bead.start};
      last_s += motion::duration(motion::line_move(limits_, down[0], down[1]));
      if (auto r = builder.would_be_free(down, rules); !r) return r;
    }
    if (kind != RunUp::Kind::Whole && last_s < m.valve_open_lead)  // of a whole one it was looked at
      return fail(Fault::NoSolution, "the valve would open before the needle's last descent and run-up");
    if (auto r = builder.would_be_free(run_up, rules); !r) return r;
    return surroundings()->keeps_gap(run_up, work);
  });
}

/// The valve is shut and the needle stands behind the bead's end: back along the bead, rising meanwhile.
Result<void> BlockPlanner::leave_bead(BlockBuilder& builder, const recipes::Bead& bead,
                                      const motion::PathRules& rules) const {
  const recipes::Material& m = *recipes::find_material(recipe_, bead.material);
  if (m.back_track <= 0 && m.tail_lift <= 0) return {};
  double off = std::max(bead.corner_tolerance, kBackTrack_mm);
  if (!is_level(bead)) off = recipes::upright_tolerance_mm(off, m);
  off *= kEachOfBack;
  const std::vector<Vec3> back = recipes::retrace(bead, m.back_track, off).points;
  if (const double all = length_of(back); all > 0) {
    const AxisVec end = needle_at(flat(back.front()), back.front().z + m.gap);
    // A bend up at the bead's end would dip before it rises.
    if (m.tail_lift > 0)
      if (auto r = builder.straight(end, rules, m.speed); !r) return r;
    std::vector<AxisVec> points{builder.at()};
    double gone = 0;
    for (std::size_t i = 0; i < back.size(); ++i) {
      if (i > 0) gone += norm(back[i] - back[i - 1]);
      AxisVec& to = points.emplace_back(needle_at(flat(back[i]), back[i].z + m.gap));
      rise(to, m.tail_lift * gone / all);
    }
    double speed_mm_s = m.speed;
    for (int slower = 0;; ++slower, speed_mm_s /= 2) {  // where its targets would come too near to a body
      const auto path = motion::plan_dry(limits_, points, speed_mm_s, off);
      if (!path) return tl::unexpected(path.error());
      // No speed makes a way free that is not.
      if (slower == 0)
        if (auto r = builder.would_be_free(motion::chords(*path), rules, motion::off_chords_mm(*path)); !r) return r;
      auto gone_back = builder.path(*path, points.back(), rules, "back along");
      if (gone_back || gone_back.error().fault != Fault::Collision || slower == kSlowerBack) return gone_back;
    }
  }
  AxisVec up = builder.at();
  rise(up, m.tail_lift);
  return builder.straight(up, rules, m.speed);
}

Result<ProvenBlock> BlockPlanner::park(std::uint32_t block, const AxisVec& from) const {
  BlockBuilder builder = build(block, from);
  const recipes::Location last = last_location(recipe_);
  builder.about({"the park position", "", recipe_.file, last});
  if (auto r = builder.travel(parked(machine_, from), surroundings()->travelling(from)); !r)
    return tl::unexpected(with_line(r.error(), recipe_, last, "parking"));
  auto planned = builder.finish();
  if (!planned) return tl::unexpected(with_line(planned.error(), recipe_, last, "parking"));
  return over_board(*std::move(planned), "parking", last);
}

}  // namespace gantry::job
