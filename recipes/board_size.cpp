#include "recipes/board_size.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "recipes/on_board.hpp"

namespace gantry::recipes {
namespace {

using written::FeatureRow;

/// Of each thing that has to be on the board.
std::vector<Vec2> points_of(const Recipe& recipe, const std::vector<FeatureRow>& rows) {
  std::vector<Vec2> all;
  for (const MarkDef& m : recipe.marks) all.push_back(m.at);
  for (const TouchPoint& t : recipe.touches) all.push_back(t.at);
  for (const Part& p : recipe.parts)
    if (!p.fixture) all.push_back(p.at);
  for (const FeatureRow& row : rows) {
    if (row.off_board) continue;
    for (const auto* point : {&row.at, &row.to, &row.centre})
      if (point->given()) all.push_back(flat(point->value));
    for (const auto& point : row.points) all.push_back(flat(point.value));
  }
  return all;
}

}  // namespace

bool size_is_wrong(const Recipe& recipe, const std::vector<FeatureRow>& rows, config::Mistakes& mistakes) {
  constexpr std::ptrdiff_t kFew = 4;
  const Vec2 size = recipe.board.size;
  if (size.x <= 0 || recipe.board.locations.size.line == 0) return false;
  const std::vector<Vec2> points = points_of(recipe, rows);
  Board swapped = recipe.board;
  swapped.size = {size.y, size.x};
  const auto beside = [&](const Board& board) {
    return std::count_if(points.begin(), points.end(), [&](Vec2 p) { return !on_board(board, p); });
  };
  const auto off = beside(recipe.board);
  if (off < kFew) return false;
  const bool turned = beside(swapped) == 0;
  if (!turned && 2 * off <= static_cast<std::ptrdiff_t>(points.size())) return false;
  mistakes.add(Fault::OutOfRange,
               fmt::format("{} of {} points of the recipe lie off the board, which is {:.6g} x {:.6g} mm; {}", off,
                           points.size(), size.x, size.y,
                           turned ? fmt::format("with its edges swapped all lie on it: write 'size' as [{:.6g} mm, "
                                                "{:.6g} mm]",
                                                size.y, size.x)
                                  : std::string("correct its 'size'")),
               recipe.board.locations.size);
  return true;
}

}  // namespace gantry::recipes
