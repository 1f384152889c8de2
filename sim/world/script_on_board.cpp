#include "sim/world/script_on_board.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/near_word.hpp"

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
    if (const auto* action = std::get_if<WorldAction>(&e.action))
      if (const auto* obstacle = std::get_if<act::AddObstacle>(action)) k.obstacles.push_back(obstacle->name);
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

std::string trouble(const Action& action, const Known& k) {
  const auto* a = std::get_if<WorldAction>(&action);
  if (a == nullptr) return {};
  if (const auto* stain = std::get_if<act::Stain>(a))
    return stain->from.empty() ? std::string() : lacks("mark", stain->from, k.marks);
  if (const auto* removed = std::get_if<act::RemoveMark>(a)) return lacks("mark", removed->name, k.marks);
  if (const auto* moved = std::get_if<act::MoveMark>(a)) return lacks("mark", moved->name, k.marks);
  if (const auto* gone = std::get_if<act::RemoveObstacle>(a)) return lacks("obstacle", gone->name, k.obstacles);
  return {};
}

}  // namespace

std::vector<Error> misfits_of(std::span<const ScriptEntry> entries, const BoardPlan& plan,
                              std::vector<std::string> obstacles) {
  const Known known = known_of(entries, plan, std::move(obstacles));
  std::vector<Error> errors;
  for (const ScriptEntry& e : entries)
    for (std::string why : {trouble(e.trigger, known), trouble(e.action, known)})
      if (!why.empty()) errors.push_back({Fault::UnknownReference, "this never happens: " + why, e.where});
  return errors;
}

}  // namespace gantry::sim
