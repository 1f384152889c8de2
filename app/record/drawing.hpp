// What the report draws under the path, taken from the recipe and the machine.
//   result.drawing = drawing_of(recipe, machine, job);
#pragma once
#include "app/record/job_result.hpp"
#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "recipes/recipe.hpp"

namespace gantry::record {

/// Parts that a machine or recipe lacks are left out; the report then draws less.
Drawing drawing_of(const recipes::Recipe& recipe, const config::Machine& machine, const recipes::Job& job);

}  // namespace gantry::record
