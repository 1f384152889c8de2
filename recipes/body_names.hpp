// Messages, and pairs that may come near each other, name bodies: in one scene no two have one name.
//   check_body_names(recipe, machine, mistakes);
#pragma once
#include "config/machine.hpp"
#include "config/yaml.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// Parts and fixtures against the machine's scene and the board, zones against the machine's. Fault::DuplicateKey where
/// the recipe's stands. Within a recipe parse() looks.
void check_body_names(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes);

}  // namespace gantry::recipes
