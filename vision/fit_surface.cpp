#include "vision/fit_surface.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/tilt_known.hpp"

namespace gantry::vision {
namespace {

/// Minimum-norm least-squares slope: directions that the points leave unknown are level.
Vec2 fit_slope(std::span<const TouchedHeight> touches, const TiltKnown& known, double z_mean) {
  Vec2 xz, slope;
  for (const TouchedHeight& t : touches) xz = xz + (t.at_mm - known.mean) * (t.z_mm - z_mean);
  if (known.along_known) slope = slope + known.along * (dot(known.along, xz) / known.along_mm2);
  if (known.across_known) slope = slope + known.across * (dot(known.across, xz) / known.across_mm2);
  return slope;
}

}  // namespace

Result<SurfaceFit> fit_surface(std::span<const TouchedHeight> touches, const SurfaceRules& rules) {
  if (touches.empty()) return fail(Fault::ProbeNeverTriggered, "no height was touched; the surface is not known");
  for (const TouchedHeight& t : touches)
    if (!std::isfinite(t.at_mm.x + t.at_mm.y + t.z_mm))
      return fail(Fault::HeightsDisagree, fmt::format("the height of {} is not a number", t.name));
  const auto n = static_cast<double>(touches.size());
  double z_mean = 0;
  std::vector<Vec2> points;
  for (const TouchedHeight& t : touches) points.push_back(t.at_mm), z_mean += t.z_mm / n;
  const TiltKnown known(points);

  SurfaceFit fit;
  fit.slope = fit_slope(touches, known, z_mean);
  fit.z0_mm = z_mean - dot(fit.slope, known.mean);
  fit.rank = 1 + known.along_known + known.across_known;
  fit.redundancy = static_cast<int>(touches.size()) - fit.rank;
  double square = 0;
  std::string named;
  for (const TouchedHeight& t : touches) {
    const double r = t.z_mm - fit.at(t.at_mm);
    fit.residuals.push_back({t.name, r});
    square += r * r;
    fit.max_mm = std::max(fit.max_mm, std::abs(r));
    named += fmt::format("{}{} {:+.3f} mm", named.empty() ? "" : ", ", t.name, r);
  }
  fit.rms_mm = std::sqrt(square / n);
  if (!(fit.max_mm <= rules.max_residual_mm))
    return fail(Fault::HeightsDisagree, fmt::format("the touched heights lie more than {:.3f} mm off one plane: {}",
                                                    rules.max_residual_mm, named));
  if (!(norm(fit.slope) <= rules.max_slope))
    return fail(
        Fault::HeightsDisagree,
        fmt::format("the board would be tilted by {:.2f} mm over 100 mm, more than the {:.2f} mm that is allowed "
                    "(`touch_rules.max_tilt`); check its seat",
                    100 * norm(fit.slope), 100 * rules.max_slope));
  return fit;
}

}  // namespace gantry::vision
