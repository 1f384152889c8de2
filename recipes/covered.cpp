#include "recipes/covered.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

namespace gantry::recipes {
namespace {

constexpr double kTouchWidth_mm = 1.5;  // what a stylus and a deposit are wide, from middle to middle

double off_mm(Vec2 p, Vec2 from, Vec2 to) {
  const Vec2 along = to - from;
  const double squared = along.x * along.x + along.y * along.y;
  const double t = squared > 0 ? ((p.x - from.x) * along.x + (p.y - from.y) * along.y) / squared : 0;
  return norm(from + along * std::clamp(t, 0.0, 1.0) - p);
}

double off_mm(Vec2 p, const Dot& dot) { return norm(dot.at - p); }

double off_mm(Vec2 p, const Bead& bead) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < bead.points.size(); ++i)
    least = std::min(least, off_mm(p, flat(bead.points[i - 1]), flat(bead.points[i])));
  return least;
}

/// The first feature within `reach_mm` of a place; null: there is none.
const Feature* over(const Recipe& recipe, Vec2 at, double reach_mm) {
  const auto found = std::ranges::find_if(recipe.features, [&](const Feature& each) {
    return std::visit([&](const auto& feature) { return off_mm(at, feature) <= reach_mm; }, each);
  });
  return found == recipe.features.end() ? nullptr : &*found;
}

}  // namespace

void add_covered(const Recipe& recipe, std::vector<std::string>& to) {
  constexpr const char* kAnew = "a job that is taken up again (`--finish`, `--from`, `--only`)";
  const auto mark_under = [&](const MarkDef& mark, const std::string& what) {
    to.push_back(fmt::format("mark '{}' (line {}) is covered by {}: {} does not find it; move one of them", mark.name,
                             mark.location.line, what, kAnew));
  };
  const auto touch_on = [&](const TouchPoint& touch, const std::string& what, const char* into) {
    to.push_back(fmt::format("touch '{}' (line {}) lies on {}: {} puts the probe into {}; move one of them", touch.name,
                             touch.location.line, what, kAnew, into));
  };
  for (const MarkDef& mark : recipe.marks)
    if (const Feature* feature = over(recipe, mark.at, mark.diameter / 2))
      mark_under(mark, fmt::format("'{}'", id_of(*feature)));
  for (const TouchPoint& touch : recipe.touches)
    if (const Feature* feature = over(recipe, touch.at, kTouchWidth_mm))
      touch_on(touch, fmt::format("'{}'", id_of(*feature)), "it");
  if (!recipe.purge || !recipe.purge->frame.empty()) return;
  const Vec2 shots = flat(recipe.purge->at);
  for (const MarkDef& mark : recipe.marks)
    if (norm(mark.at - shots) <= mark.diameter / 2) mark_under(mark, "the purge's shots");
  for (const TouchPoint& touch : recipe.touches)
    if (norm(touch.at - shots) <= kTouchWidth_mm) touch_on(touch, "the purge's shots", "them");
}

}  // namespace gantry::recipes
