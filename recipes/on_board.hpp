// Whether a point lies on a recipe's board.
//   require_on_board(board, p, place, "point", mistakes);   // Fault::OutOfRange with the point and the board's size
#pragma once
#include <fmt/format.h>
#include <string_view>

#include "config/yaml.hpp"
#include "core/vec.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// True as well where the board's size could not be read.
inline bool on_board(const Board& board, Vec2 p) {
  constexpr double kSlack = 1e-9;
  const Vec2 size = board.size;
  return size.x <= 0 || (p.x >= -kSlack && p.y >= -kSlack && p.x <= size.x + kSlack && p.y <= size.y + kSlack);
}

/// False, and a mistake, when it does not. `unless`: what else may be written, "; ..."; "" where there is nothing.
inline bool require_on_board(const Board& board, Vec2 p, Location location, std::string_view what,
                             config::Mistakes& mistakes, std::string_view unless = {}) {
  if (on_board(board, p)) return true;
  mistakes.add(Fault::OutOfRange,
               fmt::format("the {} at ({:.6g}, {:.6g}) mm is off the board, which is {:.6g} x {:.6g} mm{}", what, p.x,
                           p.y, board.size.x, board.size.y, unless),
               location);
  return false;
}

}  // namespace gantry::recipes
