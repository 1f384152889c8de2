// Two marks that look alike and lie in one window of the camera: it finds two things where it looks for one, and the
// job ends at its first mark.
//   if (auto apart = marks_apart(recipe, machine); !apart) return tl::unexpected(apart.error());
#pragma once
#include "config/machine.hpp"
#include "core/error.hpp"
#include "recipes/recipe.hpp"

namespace gantry::job {

/// Fault::Inconsistent at the second of two marks of one brightness and, but for what vision::FindRules tell apart, one
/// diameter, when the camera, over the one, sees all of the other with its centre within `camera: search`. The board
/// lies at its nominal placement: off it, marks that are a little farther apart may be seen together too.
Result<void> marks_apart(const recipes::Recipe& recipe, const config::Machine& machine);

}  // namespace gantry::job
