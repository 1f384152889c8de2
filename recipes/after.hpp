// What rows of a recipe say with `after`: which rows they wait for.
//   auto rows = written::rows_before(read->features, recipe.order, all_read, mistakes);      // of each row, others
#pragma once
#include <cstdint>
#include <vector>

#include "recipes/recipe_file.hpp"

namespace gantry::recipes::written {

/// Mistakes: a name that no feature has; features that wait for one another in a circle; in the order of the file one
/// that waits for a feature behind it. Without mistakes no circle is left.
std::vector<std::vector<std::uint32_t>> rows_before(const std::vector<FeatureRow>& rows, Order order, bool all_read,
                                                    config::Mistakes& mistakes);

}  // namespace gantry::recipes::written
