// A board's size that is wrong itself: most of the recipe lies beside the board, or all of it would lie on one with its
// edges swapped. One mistake at the size then stands for one at each thing.
//   if (size_is_wrong(recipe, rows, mistakes)) recipe.board.size = {};      // nothing more is measured by it
#pragma once
#include <vector>

#include "recipes/recipe_file.hpp"

namespace gantry::recipes {

/// True, and a mistake, when it is. Looks at where marks, touches, parts and features are, at one point of each.
bool size_is_wrong(const Recipe& recipe, const std::vector<written::FeatureRow>& rows, config::Mistakes& mistakes);

}  // namespace gantry::recipes
