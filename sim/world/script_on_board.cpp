#include "sim/world/script_on_board.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/near_word.hpp"
#include "sim/script/script.hpp"

namespace gantry::sim {
namespace {

using Kind = Trigger::Kind;

struct Known {
  std::vector<std::string> marks, features, obstacles;
  std::size_t dots = 0, beads = 0, touches = 0;
};

Known known_of(std::span<const ScriptEntry> entries, const BoardPlan& plan, std::vector<std::string> obstacles) {
  Known k;
  k.obstacles = std::move(obstacles);
  k.touches = plan.touches;
  for (const recipes::MarkDef& m : plan.marks) k.marks.push_back(m.name);
  for (const BoardPlan::Feature& f : plan.features) k.features.push_back(f.id), ++(f.bead ? k.beads : k.dots);
  for (const ScriptEntry& e : entries)
    if (e.action.kind == ActionKind::AddObstacle) k.obstacles.push_back(e.action.name);
  return k;
}

/// Why there is no such thing, or nothing.
std::string lacks(std::string_view what, const std::string& name, const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), name) != names.end()) return {};
  return fmt::format("there is no {} '{}'; {}", what, name, did_you_mean(name, {names.begin(), names.end()}));
}
std::string lacks(std::string_view what, std::uint64_t number, std::size_t count) {
  return number <= count ? std::string() : fmt::format("there is no {} {}; the board has {}", what, number, count);
}

std::string trouble(const Trigger& t, const Known& k) {
  switch (t.kind) {
    case Kind::NthDot: return lacks("dot", t.count, k.dots);
    case Kind::NthBead: return lacks("bead", t.count, k.beads);
    case Kind::NthTouch: return lacks("touch", t.count, k.touches);
    case Kind::FeatureId: return lacks("feature", t.name, k.features);
    case Kind::MarkExposed: return lacks("mark", t.name, k.marks);
    default: return {};
  }
}

std::string trouble(const Action& a, const Known& k) {
  switch (a.kind) {
    case ActionKind::Stain:
      if (a.name.empty()) return {};  // counted from the board's origin
      [[fallthrough]];
    case ActionKind::RemoveMark:
    case ActionKind::MoveMark: return lacks("mark", a.name, k.marks);
    case ActionKind::RemoveObstacle: return lacks("obstacle", a.name, k.obstacles);
    default: return {};
  }
}

}  // namespace

Result<void> fits_board(std::span<const ScriptEntry> entries, const BoardPlan& plan,
                        std::vector<std::string> obstacles) {
  const Known known = known_of(entries, plan, std::move(obstacles));
  std::vector<Error> errors;
  for (const ScriptEntry& e : entries)
    for (std::string why : {trouble(e.trigger, known), trouble(e.action, known)})
      if (!why.empty()) errors.push_back({Fault::UnknownReference, "this never happens: " + why, e.where});
  if (errors.empty()) return {};
  return tl::unexpected(joined(errors));
}

}  // namespace gantry::sim
