#include "app/job/turned_board.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <vector>

#include "app/job/settle.hpp"

namespace gantry::job {
namespace {

constexpr double kSquare_mm = 1;    // edges that differ by less: the seat does not tell them apart
constexpr double kSameDisc = 1.25;  // discs whose diameters differ by a smaller factor may be taken for each other

/// The marks that the camera finds where it looks for those of a board that lies right, or nothing: one is not there.
std::optional<std::vector<FoundMark>> found_on(const recipes::Recipe& recipe, double turn_rad, double window_mm) {
  const Vec2 centre = recipe.board.size * 0.5;
  std::vector<FoundMark> found;
  for (std::size_t i = 0; i < recipe.marks.size(); ++i) {
    const recipes::MarkDef& wanted = recipe.marks[i];
    double nearest_mm = window_mm;
    std::optional<Vec2> at;
    for (const recipes::MarkDef& other : recipe.marks) {
      const double ratio = std::max(wanted.diameter / other.diameter, other.diameter / wanted.diameter);
      const Vec2 there = centre + rotated(other.at - centre, turn_rad);
      if (other.bright != wanted.bright || ratio >= kSameDisc || norm(there - wanted.at) > nearest_mm) continue;
      nearest_mm = norm(there - wanted.at);
      at = there;
    }
    if (!at) return std::nullopt;
    found.push_back({i, *at});
  }
  return found;
}

/// Whether such a board is accepted when it also lies off by as much as the rules allow.
bool accepted(const recipes::Recipe& recipe, double turn_rad, double search_mm) {
  const recipes::MarkRules& rules = recipe.mark_rules;
  const auto found = found_on(recipe, turn_rad, search_mm + rules.max_shift_mm);
  if (!found) return false;
  const vision::OffsetFit fit = fit_marks(recipe, *found);
  return fit.max_mm <= rules.max_residual_mm && norm(fit.shift_mm) <= 2 * rules.max_shift_mm &&
         std::abs(fit.rotation_rad) <= 2 * rules.max_rotation_rad;
}

}  // namespace

Result<void> fits_one_way(const recipes::Recipe& recipe, const config::Machine& machine) {
  if (recipe.marks.size() < 2 || recipe.mark_rules.symmetric_allowed) return {};
  const bool square = std::abs(recipe.board.size.x - recipe.board.size.y) < kSquare_mm;
  for (const int quarters : {2, 1, 3}) {
    if (quarters != 2 && !square) continue;
    if (!accepted(recipe, quarters * std::numbers::pi / 2, machine.camera.search_mm)) continue;
    return fail(
        Fault::Inconsistent,
        fmt::format("a board that lies turned by {} deg in its seat is taken for one that lies right, as its "
                    "marks come to lie on marks; put one of them elsewhere, or write `symmetric: allowed` under "
                    "`mark_rules` where it makes no difference",
                    quarters * 90),
        at_line(recipe, recipe.marks.front().place));
  }
  return {};
}

}  // namespace gantry::job
