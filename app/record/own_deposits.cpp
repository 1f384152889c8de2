#include "app/record/own_deposits.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>
#include <variant>

#include "app/record/from_above.hpp"
#include "sim/world/board.hpp"
#include "sim/world/deposits.hpp"

namespace gantry::record {
namespace {

using job::FeatureState;

/// How far a deposit may lie beside its place.
double allowed_mm(const recipes::Recipe& recipe, std::size_t feature) {
  return std::visit(
      [&](const auto& each) {
        const recipes::Material* m = recipes::find_material(recipe, each.material);
        const double tolerance = m != nullptr ? m->tolerance_mm : recipes::Material{}.tolerance_mm;
        if constexpr (requires { each.corner_tolerance; }) return tolerance + each.corner_tolerance;
        return tolerance;
      },
      recipe.features[feature]);
}

/// It is a dot where one is wanted, and a bead as long as that: corners may be cut.
bool can_be(const Deposit& d, const sim::BoardPlan::Feature& wanted, double allowed_mm) {
  if (d.board_mm.empty()) return false;
  const bool moves = std::any_of(d.board_mm.begin(), d.board_mm.end(),
                                 [&](Vec3 p) { return from_above_mm(p, d.board_mm.front()) > sim::kDotExtent_mm; });
  if (!wanted.bead || !moves) return wanted.bead == moves;
  const double corners_mm = 2 * allowed_mm * static_cast<double>(wanted.points.size());
  return length_from_above_mm(d.board_mm) >= length_from_above_mm(wanted.points) - corners_mm;
}

Deposit as_of(Deposit d, const sim::BoardPlan::Feature& wanted) {
  d.id = wanted.id;
  d.kind = wanted.bead ? "bead" : "dot";
  if (!wanted.bead) d.board_mm.resize(1);
  d.nominal_mm.clear();
  for (const Vec3& p : wanted.points) d.nominal_mm.push_back(p + Vec3{0, 0, wanted.gap_mm});
  d.asked_gap_mm = wanted.gap_mm;
  d.error_mm = sim::path_error(d.board_mm, wanted.points);
  d.gap_mm = wanted.gap_mm + sim::gap_error(d.board_mm, wanted.points, wanted.gap_mm);
  d.speed.reset();
  return d;
}

}  // namespace

std::vector<Own> own_deposits(const JobResult& result, const recipes::Recipe& recipe,
                              std::span<const FeatureState> states) {
  std::vector<std::size_t> dispensed, laid;
  for (const std::size_t f : result.feature_order)
    if (states[f] == FeatureState::Done)
      dispensed.push_back(f);
    else if (states[f] != FeatureState::Open && states[f] != FeatureState::LeftOut)
      return {};  // what was cut may have left nothing, or two
  for (std::size_t i = 0; i < result.deposits.size(); ++i)
    if (result.deposits[i].kind != sim::kPurgeKind) laid.push_back(i);
  if (laid.size() != dispensed.size()) return {};

  std::unordered_map<std::string, std::size_t> index_of;
  for (std::size_t f = 0; f < recipe.features.size(); ++f) index_of.emplace(recipes::id_of(recipe.features[f]), f);
  std::vector<std::size_t> strays;  // in both lists
  for (std::size_t i = 0; i < laid.size(); ++i) {
    const Deposit& d = result.deposits[laid[i]];
    if (d.id == recipes::id_of(recipe.features[dispensed[i]])) continue;
    const auto other = index_of.find(d.id);
    if (other != index_of.end() && d.error_mm <= allowed_mm(recipe, other->second)) return {};
    strays.push_back(i);
  }
  if (strays.empty()) return {};
  const sim::BoardPlan plan = sim::board_plan(recipe);
  std::unordered_map<std::string, const sim::BoardPlan::Feature*> wanted;
  for (const sim::BoardPlan::Feature& f : plan.features) wanted.emplace(f.id, &f);
  std::vector<Own> own;
  for (const std::size_t i : strays) {
    const std::size_t feature = dispensed[i];
    const sim::BoardPlan::Feature& its = *wanted.at(recipes::id_of(recipe.features[feature]));
    const Deposit& d = result.deposits[laid[i]];
    if (!can_be(d, its, allowed_mm(recipe, feature))) return {};
    own.push_back({laid[i], as_of(d, its)});
  }
  return own;
}

}  // namespace gantry::record
