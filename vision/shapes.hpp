// Shapes of marks as signed distance functions: negative inside, 0 on the edge, in pixels, relative to the mark's
// centre. Whoever finds or draws a mark asks only this, so that ring, cross or a CAD polygon join here and nowhere
// else.
//   Distance d = distance(Disc{.diameter_px = 100}, {49, 0});   // d.value == -1, d.gradient == {1, 0}
#pragma once
#include <variant>

#include "core/vec.hpp"

namespace gantry::vision {

struct Disc {
  double diameter_px = 0;
};
using Shape = std::variant<Disc>;

struct Distance {
  double value = 0;  ///< px
  Vec2 gradient;     ///< unit vector away from the shape; any unit vector where it is not defined (a disc's centre)
};
Distance distance(const Shape& shape, Vec2 from_centre);

/// Radius of the circle about the centre that holds the shape, px.
double reach_px(const Shape& shape);
/// Radius of the largest circle about the centre inside the shape's edge, px: bounds how far from the edge one may
/// look.
double depth_px(const Shape& shape);

/// What is looked for.
struct MarkModel {
  Shape shape;
  bool bright = true;  ///< brighter than what surrounds it
};

}  // namespace gantry::vision
