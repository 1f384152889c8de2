// Parallel lines that cover an area, each run to and fro as one polyline (serpentine) or each line by itself. Every
// line is the middle of a strip `spacing_mm` wide, and keeps half of that from the outline; what is left over beside
// the strips is shared by both sides. Where a line cannot be joined to the next one within the area (it is not convex),
// a new run begins.
//   auto filled = fill_area(outline, {.spacing_mm = 2, .angle_rad = 0}, most_points);   // Result<FilledArea>
// Pure, mm.
#pragma once
#include <cstddef>
#include <vector>

#include "core/error.hpp"
#include "core/vec.hpp"

namespace gantry::recipes {

inline constexpr std::size_t kMostCorners = 500;  ///< of an outline; each is looked at with each other

struct FillLines {
  double spacing_mm = 0;  ///< > 0
  double angle_rad = 0;   ///< of the lines, from X, counter-clockwise
  bool serpentine = true;
};
/// What no line covers: it is the middle of a strip as wide as the spacing, which ends half a spacing beyond its ends.
struct Bare {
  double share = 0;  ///< of the area
  double farthest_mm =
      0;    ///< from the nearest line; as far as the area was sampled, which is by a quarter of a spacing
  Vec2 at;  ///< there
};
struct FilledArea {
  std::vector<std::vector<Vec2>> runs;  ///< each a polyline of two points or more
  double area_mm2 = 0;                  ///< within the outline
  Bare bare;
};

/// outline: three corners or more, the last joined to the first, in any sense of rotation.
/// Fault::Inconsistent: the outline crosses or touches itself, or has no room for a line; Fault::TooManySteps.
Result<FilledArea> fill_area(const std::vector<Vec2>& outline, const FillLines& lines, std::size_t most);

}  // namespace gantry::recipes
