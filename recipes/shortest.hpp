// An order of features with little travel between them. A feature keeps its direction, and what must come before
// another does. It starts from the order of the file and from that of always the nearest, and betters both: by turning
// a stretch of the order round (2-opt, Croes 1958), by swapping two stretches that follow one another (or-3opt), then
// by kicks that are kept when they help (Lourenço, Martin and Stützle 2003, "Iterated local search").
//   std::vector<std::size_t> order = shortest_order(ends, before);
// A pure function: a budget in steps, never in seconds. It is in_rows(before) where nothing shorter is found.
#pragma once
#include <span>
#include <vector>

#include "recipes/precedence.hpp"
#include "recipes/travel.hpp"

namespace gantry::recipes {

std::vector<std::size_t> shortest_order(std::span<const Ends> ends, const Precedence& before);

}  // namespace gantry::recipes
