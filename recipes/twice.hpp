// Deposits on one spot: the same dot or bead written twice, and a purge on the work.
//   check_twice(recipe, mistakes);
//   if (const Feature* hit = feature_near(recipe, {20, 20}, kPurgeClear_mm)) ...
#pragma once
#include "config/yaml.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

constexpr double kSameSpot_mm = 0.1;    ///< nearer, two deposits of one material are one spot
constexpr double kPurgeClear_mm = 1.0;  ///< a purge's shots spread

/// Two dots of one material on one spot, two beads of one material along the same points, forwards or backwards.
/// Another material may lie on the first. Each feature of the recipe is told once. Its time is linear in the recipe.
void check_twice(const Recipe& recipe, config::Mistakes& mistakes);

/// The first feature that comes as near as this to a point of the board, seen from above; null: none does.
const Feature* feature_near(const Recipe& recipe, Vec2 at, double within_mm);

}  // namespace gantry::recipes
