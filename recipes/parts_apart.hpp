// Parts of a recipe that are wholly inside another one, where they change nothing.
//   check_parts_apart(recipe, mistakes);
#pragma once
#include "config/yaml.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// Of two that are the same the later one is told. A part that stands out of another at the top or at a side makes one
/// with steps of both, which may be meant. Not of fixtures.
void check_parts_apart(const Recipe& recipe, config::Mistakes& mistakes);

}  // namespace gantry::recipes
