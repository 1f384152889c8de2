// Sub-pixel position of a shape: a robust least-squares fit of
//   I(p) = A + g . (p - p0) + C Phi(-sdf(p) / sigma)
// to the raw pixels beside the edge. sdf: signed distance to the shape at (x, y) with a scale; Phi: the normal
// distribution, an edge blurred by optics and pixel. Tukey's weights take stains and glare out.
//   ShapeFit fit = fit_shape(image, model, start, effort);
// One code path for every shape of shapes.hpp.
#pragma once
#include <array>
#include <vector>

#include "vision/camera.hpp"
#include "vision/shapes.hpp"

namespace gantry::vision {

struct ShapeFit {
  Vec2 at_px;
  double scale = 1;     ///< of the shape against its model
  double blur_px = 1;   ///< sigma of the edge
  double level = 0;     ///< A: grey outside at the start point
  double contrast = 0;  ///< C: grey inside minus grey outside
  Vec2 gradient;        ///< g, grey levels per px
  Vec2 start_px;        ///< p0
  double noise = 0;     ///< robust sigma of the residuals, grey levels
  Vec2 sigma_px;        ///< standard deviation of at_px from the fit's covariance
  bool converged = false;
};

inline constexpr std::size_t kSectors = 24;
/// Sectors about the mark's centre that a fit leaves out; all false: none.
using SectorMask = std::array<bool, kSectors>;
std::size_t sector_of(Vec2 from_centre);

struct FitEffort {
  int stride = 1;  ///< take each n-th pixel in both directions
  int iterations = 12;
  double relax = 0;    ///< starts with outliers up to this share of the contrast allowed in; fades out
  double band_px = 0;  ///< distance from the edge up to which pixels count; 0: a quarter of the mark's depth, 4..12
  SectorMask leave_out{};
};

/// `start`: at_px within a few px of the truth, scale and blur roughly right; the rest is not used.
ShapeFit fit_shape(const Image& image, const MarkModel& model, const ShapeFit& start, const FitEffort& effort);

/// Grey value that the fit expects at a point, and the parts of it.
struct Expected {
  double grey = 0;
  double sdf = 0;        ///< px, of the scaled shape
  double inside = 0;     ///< Phi
  double per_shift = 0;  ///< change of grey when the edge moves outwards by 1 px
};
Expected expected_at(const MarkModel& model, const ShapeFit& fit, Vec2 at_px);

/// Band that `effort` stands for.
double band_px(const MarkModel& model, const FitEffort& effort);

}  // namespace gantry::vision
