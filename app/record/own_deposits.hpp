// What was dispensed for which feature, where a deposit lies so far beside its place that the world, which goes by
// geometry alone, finds it on no feature or on another one: a board that nobody has looked for lies anywhere.
//   for (const Own& o : own_deposits(result, recipe, states)) judge o.deposit in place of result.deposits[o.index];
// A job opens the valve once for each feature, one after the other. Where it has left as many deposits as it has
// dispensed features, the first is that of the first, and so on; unless one of them lies where another feature wants
// it.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "app/job/job_state.hpp"
#include "app/record/job_result.hpp"
#include "recipes/recipe.hpp"

namespace gantry::record {

struct Own {
  std::size_t index = 0;  ///< in JobResult::deposits
  Deposit deposit;        ///< with the feature's name, and measured by it; without speed
};

/// Nothing: each lies on its own, or nobody can tell whose it is; then what a feature lacks is missing.
std::vector<Own> own_deposits(const JobResult& result, const recipes::Recipe& recipe,
                              std::span<const job::FeatureState> states);

}  // namespace gantry::record
