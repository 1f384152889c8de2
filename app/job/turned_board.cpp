#include "app/job/turned_board.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <vector>

#include "app/job/settle.hpp"

namespace gantry::job {
namespace {

constexpr double kSquare_mm = 1;    // edges that differ by less: the seat does not tell them apart
constexpr double kSameDisc = 1.25;  // discs whose diameters differ by a smaller factor may be taken for each other

/// How a board may be put into its seat: where its edges along X and Y then run.
struct WrongWay {
  const char* words;
  bool of_squares;  ///< only a square board fits its seat like this
  Vec2 x, y;
};

constexpr WrongWay kWrongWays[] = {
    {"turned by 180 deg in its seat", false, {-1, 0}, {0, -1}},
    {"turned by 90 deg in its seat", true, {0, 1}, {-1, 0}},
    {"turned by 270 deg in its seat", true, {0, -1}, {1, 0}},
    {"turned over, its bottom up, about its X direction", false, {1, 0}, {0, -1}},
    {"turned over, its bottom up, about its Y direction", false, {-1, 0}, {0, 1}},
    {"turned over, its bottom up, about the diagonal through its origin", true, {0, 1}, {1, 0}},
    {"turned over, its bottom up, about the diagonal beside its origin", true, {0, -1}, {-1, 0}},
};

/// The marks that the camera finds where it looks for those of a board that lies right, or nothing: one is not there.
std::optional<std::vector<FoundMark>> found_on(const recipes::Recipe& recipe, const WrongWay& lies, double window_mm) {
  const Vec2 centre = recipe.board.size * 0.5;
  std::vector<FoundMark> found;
  for (std::size_t i = 0; i < recipe.marks.size(); ++i) {
    const recipes::MarkDef& wanted = recipe.marks[i];
    double nearest_mm = window_mm;
    std::optional<Vec2> at;
    for (const recipes::MarkDef& other : recipe.marks) {
      const double ratio = std::max(wanted.diameter / other.diameter, other.diameter / wanted.diameter);
      const Vec2 from_centre = other.at - centre;
      const Vec2 there = centre + lies.x * from_centre.x + lies.y * from_centre.y;
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
bool accepted(const recipes::Recipe& recipe, const WrongWay& lies, double search_mm) {
  const recipes::MarkRules& rules = recipe.mark_rules;
  const auto found = found_on(recipe, lies, search_mm + rules.max_shift_mm);
  if (!found) return false;
  const vision::OffsetFit fit = fit_marks(recipe, *found);
  return fit.max_mm <= rules.max_residual_mm && norm(fit.shift_mm) <= 2 * rules.max_shift_mm &&
         std::abs(fit.rotation_rad) <= 2 * rules.max_rotation_rad;
}

}  // namespace

Result<void> fits_one_way(const recipes::Recipe& recipe, const config::Machine& machine) {
  if (recipe.marks.size() < 2 || recipe.mark_rules.symmetric_allowed) return {};
  const bool square = std::abs(recipe.board.size.x - recipe.board.size.y) < kSquare_mm;
  for (const WrongWay& way : kWrongWays) {
    if (way.of_squares && !square) continue;
    if (!accepted(recipe, way, machine.camera.search_mm)) continue;
    return fail(Fault::Inconsistent,
                fmt::format("a board that lies {} is taken for one that lies right, as its marks come to lie on marks; "
                            "put one of them elsewhere, make its diameter larger by a quarter or more, or write "
                            "`symmetric: allowed` under `mark_rules` where it "
                            "makes no difference",
                            way.words),
                at_line(recipe, recipe.marks.front().location));
  }
  return {};
}

}  // namespace gantry::job
