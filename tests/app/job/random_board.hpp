// A random board on the reference machine: clips, low parts, shelves and ledges under and around what is touched,
// looked at and dispensed, many of them as near as the clearance to within a nanometre; and where the board truly lies.
#pragma once
#include <cstdint>

#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "sim/world/board.hpp"

namespace gantry::test {

struct RandomBoard {
  config::Machine machine;
  recipes::Recipe recipe;
  sim::BoardPlacement placement;  ///< within what the recipe's rules allow
};

/// Always the same for the same number. Every line of the recipe is another one.
RandomBoard random_board(const config::Machine& machine, std::uint64_t number);

}  // namespace gantry::test
