// How far the needle travels between features: from where it has risen off the one straight to over where the next one
// begins. In the board's frame, so that it is the same on every machine and wherever the board lies; detours about
// parts, the travel to the first feature and that from the last are not in it.
//   const auto ends = ends_of(recipe);   double mm = travel_mm(ends, order);
#pragma once
#include <span>
#include <vector>

#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// Over the first point of a feature and over where the needle leaves it, lifted; mm.
struct Ends {
  Vec3 from, to;
};
/// Of each feature of a recipe without mistakes.
std::vector<Ends> ends_of(const Recipe& recipe);

/// From feature to feature in this order (indices).
double travel_mm(std::span<const Ends> ends, std::span<const std::size_t> order);

/// What the order of a job has saved.
struct Travel {
  double as_ordered_mm = 0, in_file_order_mm = 0;
};
/// `dispensed`: the features of a job, in its order.
Travel travel_of(const Recipe& recipe, std::span<const std::size_t> dispensed);

/// "travels 412.3 mm between features; in the order of the file it would be 893.1 mm"
std::string to_text(const Travel& travel);

}  // namespace gantry::recipes
