// Finds a mark in an image, to a few hundredths of a pixel, or says why there is none.
//   Result<FoundMark> mark = find_mark(image, {.shape = Disc{100}, .bright = true}, {640, 512}, 300);
// Candidates (candidates.hpp) are fitted (fit_shape.hpp) and judged (gates.hpp); two that pass are none: a wrong mark
// is worse than no mark.
#pragma once
#include "core/error.hpp"
#include "vision/camera.hpp"
#include "vision/gates.hpp"
#include "vision/shapes.hpp"

namespace gantry::vision {

struct FoundMark {
  Vec2 at_px;           ///< pixel (0, 0) has its centre at (0, 0)
  Vec2 sigma_px;        ///< standard deviation from the fit; pixel noise only
  double scale = 1;     ///< size against the model
  double blur_px = 0;   ///< sigma of the edge
  double contrast = 0;  ///< grey inside minus grey outside
  double noise = 0;     ///< grey levels, robust sigma
  double coverage = 0;  ///< share of the edge that was seen, 0..1
};

/// Searches where the mark's centre may be: within `search_radius_px` of `expected_px`.
/// Fault::MarkNotFound with what the best candidate lacks, Fault::MarkAmbiguous with the places of both.
Result<FoundMark> find_mark(const Image& image, const MarkModel& model, Vec2 expected_px, double search_radius_px,
                            const FindRules& rules = {});

}  // namespace gantry::vision
