// What the report draws under and around the path, taken from the recipe and the machine.
//   result.drawing = drawing_of(recipe, machine, job);   ...   result.drawing = placed_drawing(result, recipe,
//   machine);
#pragma once
#include "app/record/job_result.hpp"
#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "recipes/recipe.hpp"

namespace gantry::record {

/// Parts that a machine or recipe lacks are left out; the report then draws less.
Drawing drawing_of(const recipes::Recipe& recipe, const config::Machine& machine, const recipes::Job& job);

/// The result's drawing with board, parts, marks and features where the job has found the board: offset and surface of
/// the result.
[[nodiscard]] Drawing placed_drawing(const JobResult& result, const recipes::Recipe& recipe,
                                     const config::Machine& machine);

}  // namespace gantry::record
