#include "app/job/settle.hpp"

#include <fmt/format.h>

#include "recipes/surface_doubt.hpp"

namespace gantry::job {
namespace {

std::vector<vision::MarkPair> pairs(const recipes::Recipe& recipe, const std::vector<FoundMark>& marks) {
  std::vector<vision::MarkPair> out;
  for (const FoundMark& m : marks) out.push_back({recipe.marks[m.mark].name, recipe.marks[m.mark].at, m.at_mm});
  return out;
}

template <class T>
Result<T> at_first_line(Result<T> fit, const recipes::Recipe& recipe, recipes::Location first) {
  if (!fit && fit.error().where.empty()) fit.error().where = at_line(recipe, first);
  return fit;
}

}  // namespace

std::string at_line(const recipes::Recipe& recipe, recipes::Location location) {
  return fmt::format("{}:{}:{}", recipe.file, location.line, location.column);
}

recipes::WorkOffset guess_offset(const recipes::Recipe& recipe, const std::vector<FoundMark>& marks) {
  if (marks.size() == 1) return {marks[0].at_mm - recipe.marks[marks[0].mark].at, 0};
  const vision::OffsetFit fit = fit_marks(recipe, marks);
  return {fit.shift_mm, fit.rotation_rad};
}

vision::OffsetFit fit_marks(const recipes::Recipe& recipe, const std::vector<FoundMark>& marks) {
  return vision::fit_rigid(pairs(recipe, marks));
}

Result<vision::OffsetFit> settle_offset(const recipes::Recipe& recipe, const std::vector<FoundMark>& marks) {
  return at_first_line(
      vision::fit_offset(pairs(recipe, marks), {.max_residual_mm = recipe.mark_rules.max_residual_mm,
                                                .max_shift_mm = recipe.mark_rules.max_shift_mm,
                                                .max_rotation_rad = recipe.mark_rules.max_rotation_rad}),
      recipe, recipe.marks.front().location);
}

Result<vision::SurfaceFit> settle_surface(const recipes::Recipe& recipe, const std::vector<TouchedHeight>& heights) {
  std::vector<vision::TouchedHeight> points;
  for (const TouchedHeight& h : heights)
    points.push_back({recipe.touches[h.touch].name, recipe.touches[h.touch].at, h.height_mm});
  return at_first_line(vision::fit_surface(points, {.max_residual_mm = recipe.touch_rules.max_residual_mm,
                                                    .max_slope = recipes::max_measured_slope(recipe.touch_rules)}),
                       recipe, recipe.touches.front().location);
}

}  // namespace gantry::job
