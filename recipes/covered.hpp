// What a recipe dispenses over its own marks and touches. They come first, so that a job of its own is none the worse;
// one that is taken up again looks and touches anew.
#pragma once
#include <string>
#include <vector>

#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// One note for each mark and each touch that a feature lies on.
void add_covered(const Recipe& recipe, std::vector<std::string>& to);

}  // namespace gantry::recipes
