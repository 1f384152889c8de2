// From values to the pixels of a plot.
#pragma once
#include "core/vec.hpp"

namespace gantry::record {

struct Axes {
  double left = 46, right = 992, top = 10, bottom = 200;  ///< px
  double x0 = 0, x1 = 1, y0 = 0, y1 = 1;                  ///< values at these
  [[nodiscard]] Vec2 px(double x, double y) const {
    return {left + (x - x0) / (x1 - x0) * (right - left), bottom - (y - y0) / (y1 - y0) * (bottom - top)};
  }
};

}  // namespace gantry::record
