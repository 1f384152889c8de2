// What of a recipe cannot be done however the axes move: a board that is larger than what carries it, work at edges
// that the fixture keeps for itself, or in the middle of a part; and tools that the machine lacks.
//   check_seat(recipe, machine, mistakes);   check_tools(recipe, machine, mistakes);
#pragma once
#include "config/machine.hpp"
#include "config/yaml.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// The frame is one of the machine's. False: the board does not lie where it could, and where its work lies tells
/// nothing.
bool check_seat(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes);
/// Camera, probe, needle: each is told where the recipe asks for it first.
void check_tools(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes);

}  // namespace gantry::recipes
