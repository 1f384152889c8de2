#include "recipes/travel.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::recipes {

std::vector<Ends> ends_of(const Recipe& recipe) {
  std::vector<Ends> all;
  all.reserve(recipe.features.size());
  for (const Feature& feature : recipe.features) {
    const Material& m = *std::visit([&](const auto& f) { return find_material(recipe, f.material); }, feature);
    const Vec3 lifted{0, 0, m.gap + m.retract};
    if (const auto* one = std::get_if<Dot>(&feature)) {
      const Vec3 over = Vec3{one->at.x, one->at.y, one->height_mm} + lifted;
      all.push_back({over, over});
      continue;
    }
    const Bead& bead = std::get<Bead>(feature);
    const Vec3 leaves = m.back_track > 0 ? retrace(bead, m.back_track, 0).points.back() : bead.points.back();
    all.push_back({bead.points.front() + lifted, leaves + lifted + Vec3{0, 0, m.tail_lift}});
  }
  return all;
}

double travel_mm(std::span<const Ends> ends, std::span<const std::size_t> order) {
  double mm = 0;
  for (std::size_t i = 1; i < order.size(); ++i) mm += norm(ends[order[i]].from - ends[order[i - 1]].to);
  return mm;
}

Travel travel_of(const Recipe& recipe, std::span<const std::size_t> dispensed) {
  const std::vector<Ends> ends = ends_of(recipe);
  std::vector<std::size_t> in_file(dispensed.begin(), dispensed.end());
  std::sort(in_file.begin(), in_file.end());
  return {travel_mm(ends, dispensed), travel_mm(ends, in_file)};
}

std::string to_text(const Travel& travel) {
  return fmt::format("travels {:.1f} mm between features; in the order of the file it would be {:.1f} mm",
                     travel.as_ordered_mm, travel.in_file_order_mm);
}

}  // namespace gantry::recipes
