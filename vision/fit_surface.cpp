#include "vision/fit_surface.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace gantry::vision {
namespace {

/// A direction whose points spread less than this (rms) says nothing of the tilt along it.
constexpr double kSpreadMin_mm = 0.5;

/// Minimum-norm least-squares slope of centred points: by the eigenvectors of their 2x2 scatter, leaving out directions
/// without spread.
Vec2 fit_slope(std::span<const TouchedHeight> touches, Vec2 mean, double z_mean, int& rank) {
  double xx = 0, xy = 0, yy = 0;
  Vec2 xz;
  for (const TouchedHeight& t : touches) {
    const Vec2 p = t.at_mm - mean;
    xx += p.x * p.x, xy += p.x * p.y, yy += p.y * p.y;
    xz = xz + p * (t.z_mm - z_mean);
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy),
               floor = kSpreadMin_mm * kSpreadMin_mm * static_cast<double>(touches.size());
  const Vec2 first{std::cos(angle), std::sin(angle)}, second{-first.y, first.x};
  Vec2 slope;
  rank = 1;
  for (const Vec2 axis : {first, second}) {
    const double scatter = xx * axis.x * axis.x + 2 * xy * axis.x * axis.y + yy * axis.y * axis.y;
    if (scatter < floor) continue;
    slope = slope + axis * (dot(axis, xz) / scatter);
    ++rank;
  }
  return slope;
}

}  // namespace

Result<SurfaceFit> fit_surface(std::span<const TouchedHeight> touches, const SurfaceRules& rules) {
  if (touches.empty()) return fail(Fault::ProbeNeverTriggered, "no height was touched; the surface is not known");
  for (const TouchedHeight& t : touches)
    if (!std::isfinite(t.at_mm.x + t.at_mm.y + t.z_mm))
      return fail(Fault::HeightsDisagree, fmt::format("the height of {} is not a number", t.name));
  const auto n = static_cast<double>(touches.size());
  Vec2 mean;
  double z_mean = 0;
  for (const TouchedHeight& t : touches) mean = mean + t.at_mm * (1 / n), z_mean += t.z_mm / n;

  SurfaceFit fit;
  fit.slope = fit_slope(touches, mean, z_mean, fit.rank);
  fit.z0_mm = z_mean - dot(fit.slope, mean);
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
        fmt::format("the board would be tilted by {:.2f} mm over 100 mm, more than the {:.2f} mm that is allowed; "
                    "check its seat",
                    100 * norm(fit.slope), 100 * rules.max_slope));
  return fit;
}

}  // namespace gantry::vision
