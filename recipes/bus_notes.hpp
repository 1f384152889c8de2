// What the loss of the bus or of the program costs at the speeds of a recipe, for `check`.
//   for (const auto& note : bus_notes(recipe, machine)) ...
#pragma once
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// A sentence for each material and loss.
std::vector<std::string> bus_notes(const Recipe& recipe, const config::Machine& machine);

}  // namespace gantry::recipes
