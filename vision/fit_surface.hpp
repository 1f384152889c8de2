// The board's top face from touched heights: z = z0 + slope . p, in the frame of the points.
//   Result<SurfaceFit> s = fit_surface(points, {.max_residual_mm = 0.1});
// What the touches do not show is taken as level: one touch gives a level face; touches on one line (two always are)
// give the tilt along that line and none across it, so that every touched height is met and nothing is invented.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/vec.hpp"

namespace gantry::vision {

struct TouchedHeight {
  std::string name;
  Vec2 at_mm;
  double z_mm = 0;
};

struct SurfaceRules {
  double max_residual_mm = 0.1;  ///< of any touch from the plane
  double max_slope = 0.02;       ///< mm per mm
};

struct HeightResidual {
  std::string name;
  double residual_mm = 0;  ///< touched minus plane
};

struct SurfaceFit {
  double z0_mm = 0;
  Vec2 slope;
  int rank = 1;        ///< 1: level, 2: tilt along one line known, 3: a plane
  int redundancy = 0;  ///< touches more than the fit needs; 0: residuals say nothing
  std::vector<HeightResidual> residuals;
  double rms_mm = 0, max_mm = 0;
  [[nodiscard]] double at(Vec2 p) const { return z0_mm + dot(slope, p); }
};

/// Fault::ProbeNeverTriggered without touches, Fault::HeightsDisagree with every residual or the slope.
Result<SurfaceFit> fit_surface(std::span<const TouchedHeight> touches, const SurfaceRules& rules);

}  // namespace gantry::vision
