// What a fitted shape must pass before it is called a mark. A wrong mark is worse than no mark, so each gate names a
// respect in which something else looks like one, and says so in words.
//   Judgement j = judge(image, model, fit, rules);   // j.rejected: "the contrast is reversed", empty when it is a mark
#pragma once
#include <string>

#include "vision/fit_shape.hpp"

namespace gantry::vision {

struct FindRules {
  double max_scale_error = 0.06;    ///< of the diameter against the model
  double min_contrast = 10;         ///< grey levels
  double max_noise_share = 0.6;     ///< residual sigma against contrast
  double max_blur_share = 0.06;     ///< edge sigma against the mark's radius (and never below 3 px)
  double min_coverage = 0.6;        ///< share of the 24 sectors in which the edge is where it should be
  int max_gap_sectors = 8;          ///< longest run of sectors without it
  double max_edge_shift_px = 0.75;  ///< of a sector's edge, beside noise
  double max_sector_error = 0.2;    ///< of a sector's residuals (rms) against the contrast, beside noise
  double min_interior = 0.7;        ///< share of the inside that has the mark's grey
  double max_level_error = 0.4;     ///< share of the contrast by which grey may be off, inside and around
  double min_margin = 0.15;         ///< coverage that the mark must have over the next candidate
  std::size_t candidates = 12;
  double mm_per_px = 0;  ///< for messages; 0: they speak in pixels
};

struct Judgement {
  std::string rejected;     ///< why it is no mark; empty: it is one
  bool look_alike = false;  ///< rejected for its coverage only: it may be a damaged mark
  double coverage = 0;      ///< share of sectors
  double interior = 0;      ///< share of the inside
  SectorMask bad{};         ///< sectors that do not show the edge
};

/// Gates that need only the fit: scale, contrast and its sign, blur, convergence.
std::string reject_fit(const MarkModel& model, const ShapeFit& fit, const FindRules& rules);

Judgement judge(const Image& image, const MarkModel& model, const ShapeFit& fit, const FindRules& rules);

}  // namespace gantry::vision
