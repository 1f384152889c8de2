// Whether a material's valve leads fit its features: the valve is told to open while the needle is on the last stretch
// to one (down from the retract height, along the run-up of a bead), never on its travel before that, and told to close
// after that, a cycle of the machine or more. No shot and no dwell of a material is shorter than a cycle. And what
// whole cycles make of a dot.
//   check_valve_leads(recipe, machine, mistakes);   // Fault::NoSolution, Fault::Inconsistent; once a material and kind
#pragma once
#include "config/machine.hpp"
#include "config/yaml.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

void check_valve_leads(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes);

/// How much longer or shorter than asked for a dot's valve may be open. Its edges fall on cycles: where its times are
/// no whole number of them, both may be half of one off.
[[nodiscard]] double dot_time_tolerance_s(const Material& m, double cycle_s);

}  // namespace gantry::recipes
