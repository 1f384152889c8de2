// Lengths of an image in messages: in mm where the scale is known, which is what people can measure.
//   length(33.5, rules.mm_per_px)   // "0.67 mm"; "33.5 px" without a scale
#pragma once
#include <fmt/format.h>
#include <string>

#include "core/vec.hpp"

namespace gantry::vision {

inline std::string length(double px, double mm_per_px) {
  return mm_per_px > 0 ? fmt::format("{:.2f} mm", px * mm_per_px) : fmt::format("{:.1f} px", px);
}

/// A position in the image; with a scale, from where the mark should be, along machine X and Y (the row grows with -Y).
inline std::string position(Vec2 at_px, Vec2 expected_px, double mm_per_px) {
  if (!(mm_per_px > 0)) return fmt::format("({:.1f}, {:.1f})", at_px.x, at_px.y);
  return fmt::format("({:+.2f}, {:+.2f}) mm from there", (at_px.x - expected_px.x) * mm_per_px,
                     (expected_px.y - at_px.y) * mm_per_px);
}

}  // namespace gantry::vision
