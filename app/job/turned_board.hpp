// A board that is put into its seat the wrong way round, and whose marks then lie where marks are looked for, is taken
// for one that lies right: everything is dispensed, on the wrong places.
//   if (auto one_way = fits_one_way(recipe, machine); !one_way) return tl::unexpected(one_way.error());
#pragma once
#include "config/machine.hpp"
#include "core/error.hpp"
#include "recipes/recipe.hpp"

namespace gantry::job {

/// By the outline, a board fits its seat turned by 180 deg and turned over about either of its directions, a square one
/// also turned by 90 deg and over about its diagonals; its marks are taken for holes, seen from both sides.
/// Fault::Inconsistent at the first mark when its mark rules would accept it there, unless they say
/// `symmetric: allowed`.
Result<void> fits_one_way(const recipes::Recipe& recipe, const config::Machine& machine);

}  // namespace gantry::job
