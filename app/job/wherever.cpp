#include "app/job/wherever.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "app/job/block_plan.hpp"
#include "recipes/selection.hpp"

namespace gantry::job {
namespace {

/// By how much bodies are off, seen from the board, mm.
struct Range {
  double beside = 0, above = 0;  ///< of what stays
  double turn = 0;               ///< of the head, for each mm from its tool's tip
};

/// From the board's origin.
double furthest_mm(const recipes::Recipe& recipe) {
  double most = 0;
  for (const recipes::TouchPoint& touch : recipe.touches) most = std::max(most, norm(touch.at));
  for (const recipes::Feature& feature : recipe.features) {
    if (const auto* dot = std::get_if<recipes::Dot>(&feature)) most = std::max(most, norm(dot->at));
    if (const auto* bead = std::get_if<recipes::Bead>(&feature))
      for (const Vec3 p : bead->points) most = std::max(most, norm(flat(p)));
  }
  return most;
}

Range range_of(const recipes::Recipe& recipe) {
  Range range;
  if (!recipe.marks.empty()) {
    range.turn = 2 * std::sin(recipe.mark_rules.max_rotation_rad / 2);
    range.beside = recipe.mark_rules.max_shift_mm + range.turn * furthest_mm(recipe);
  }
  if (!recipe.touches.empty()) range.above = recipe.touch_rules.window_mm;
  return range;
}

void grow(config::Body& body, const Range& range) {
  const bool round_ends = body.shape.kind == config::Shape::Kind::Capsule;
  body.shape.size = body.shape.size + Vec3{2 * range.beside, 2 * range.beside,
                                           2 * (round_ends ? range.above + range.beside : range.above)};
}

/// As seen from what is under a tool's tip.
config::Machine grown(config::Machine machine, const recipes::Recipe& recipe, const Range& range,
                      std::string_view tool) {
  const double underside = recipes::to_machine(recipe, machine, {}, {}, {0, 0}, 0).z - recipe.board.thickness;
  for (config::Body& body : machine.scene)
    if (body.centre.z + body.shape.size.z / 2 > underside + 1e-6) grow(body, range);
  for (config::Body& zone : machine.keep_out) grow(zone, range);
  const Vec3 tip = config::find_tool(machine, tool)->tip;
  for (config::Body& body : machine.head) {
    if (body.on_turn && machine.c) continue;                         // C turns it with the board
    const bool round = body.shape.kind != config::Shape::Kind::Box;  // its own turn changes nothing
    const double reach = norm(flat(body.centre - tip)) + (round ? 0 : norm(flat(body.shape.size)) / 2);
    grow(body, {.beside = range.turn * reach});
  }
  return machine;
}

void grow(recipes::Part& stays, const Range& range) {
  stays.size = stays.size + Vec3{2 * range.beside, 2 * range.beside, 2 * range.above};
  stays.underside -= range.above;
}

recipes::Recipe grown(recipes::Recipe recipe, const Range& range) {
  for (recipes::Part& part : recipe.parts)
    if (part.fixture) grow(part, range);
  for (recipes::Part& zone : recipe.keep_out) grow(zone, range);
  return recipe;
}

Vec2 begin_of(const recipes::Feature& feature) {
  const auto* dot = std::get_if<recipes::Dot>(&feature);
  return dot != nullptr ? dot->at : flat(std::get<recipes::Bead>(feature).points.front());
}

/// The head at the safe height, a tool over a place of the board.
AxisVec over(const config::Machine& machine, const recipes::Recipe& recipe, std::string_view tool, Vec2 at) {
  AxisVec q = recipes::tool_at(machine, *config::find_tool(machine, tool),
                               recipes::to_machine(recipe, machine, {}, {}, at, 0), 0);
  q[machine.z.value] = machine.safe_z_mm;
  return q;
}

/// What cannot be planned is named; an error where planning was given up.
Result<void> judge(Result<ProvenBlock> planned, std::string name, const Breath& breath,
                   std::vector<OnlyWhenPlaced>& named) {
  if (planned)
    discard(*std::move(planned), breath);
  else if (planned.error().fault == Fault::Aborted)
    return tl::unexpected(planned.error());
  else
    named.push_back({std::move(name), planned.error()});
  return {};
}

/// Touches come behind the marks, and where these have found the board.
Result<void> add_touches(const config::Machine& machine, const recipes::Recipe& recipe, const Breath& breath,
                         std::vector<OnlyWhenPlaced>& named) {
  if (recipe.marks.empty() || recipe.touches.empty()) return {};
  const Range range = range_of(recipe);
  const config::Machine among = grown(machine, recipe, range, "probe");
  const recipes::Recipe on = grown(recipe, range);
  BlockPlanner planner(among, on, breath);
  Knowledge nominal;
  nominal.offset = recipes::WorkOffset{};
  planner.know(nominal);
  for (std::size_t t = 0; t < recipe.touches.size(); ++t)
    if (auto judged = judge(planner.touch(1, over(machine, recipe, "probe", recipe.touches[t].at), t),
                            "touch " + recipe.touches[t].name, breath, named);
        !judged)
      return judged;
  return {};
}

}  // namespace

bool asks_wherever(const recipes::Recipe& recipe) { return !recipe.marks.empty() || !recipe.touches.empty(); }

Result<std::vector<OnlyWhenPlaced>> only_when_placed(const config::Machine& machine, const recipes::Recipe& recipe,
                                                     const recipes::Job& job, const Breath& breath,
                                                     const std::function<void()>& count) {
  std::vector<OnlyWhenPlaced> named;
  const std::vector<std::size_t> features = recipes::dispensed_by(job);
  if (features.empty() || !asks_wherever(recipe)) return named;
  if (auto touched = add_touches(machine, recipe, breath, named); !touched) return tl::unexpected(touched.error());
  const Range range = range_of(recipe);
  const config::Machine among = grown(machine, recipe, range, "needle");
  const recipes::Recipe on = grown(recipe, range);
  BlockPlanner planner(among, on, breath);
  Knowledge nominal;
  nominal.offset = recipes::WorkOffset{}, nominal.surface = recipes::Surface{};
  planner.know(nominal);
  planner.count(count);
  for (const std::size_t f : features)
    if (auto judged = judge(planner.dispense(1, over(machine, recipe, "needle", begin_of(recipe.features[f])), {f}),
                            recipes::id_of(recipe.features[f]), breath, named);
        !judged)
      return tl::unexpected(judged.error());
  return named;
}

std::string to_text(const std::vector<OnlyWhenPlaced>& features) {
  constexpr std::size_t kShown = 5;
  std::string names;
  for (std::size_t i = 0; i < std::min(kShown, features.size()); ++i)
    names += fmt::format("{}'{}'", i == 0 ? "" : ", ", features[i].feature);
  if (features.size() > kShown) names += fmt::format(" and {} more", features.size() - kShown);
  return fmt::format("{} ({})", names, features.front().why.message);
}

}  // namespace gantry::job
