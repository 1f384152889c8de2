// What heights at some points say about the tilt of a plane: along which directions it is known.
//   TiltKnown known(points);   known.distance_mm(p);      // from what the points say, mm
// One point gives no tilt, points on one line (two always are) give it along that line, others give all of it. The
// height of the plane over the points' mean is the mean of their heights in any case.
#pragma once
#include <cmath>
#include <span>

#include "core/vec.hpp"

namespace gantry {

struct TiltKnown {
  /// A direction in which the points spread less than this (rms about their mean) is not known.
  static constexpr double kSpreadMin_mm = 0.5;

  Vec2 mean;
  Vec2 along{1, 0}, across{0, 1};        ///< where the points spread most, and least; unit vectors
  double along_mm2 = 0, across_mm2 = 0;  ///< sums of squares about the mean
  double along_mm = 0, across_mm = 0;    ///< sums of distances from the mean
  bool along_known = false, across_known = false;

  /// At least one point.
  explicit TiltKnown(std::span<const Vec2> points) {
    const auto n = static_cast<double>(points.size());
    for (const Vec2 p : points) mean = mean + p * (1 / n);
    double xx = 0, xy = 0, yy = 0;
    for (const Vec2 each : points) {
      const Vec2 p = each - mean;
      xx += p.x * p.x, xy += p.x * p.y, yy += p.y * p.y;
    }
    // The eigenvectors of the points' 2x2 scatter.
    const double angle = 0.5 * std::atan2(2 * xy, xx - yy), floor_mm2 = kSpreadMin_mm * kSpreadMin_mm * n;
    along = {std::cos(angle), std::sin(angle)}, across = {-along.y, along.x};
    const auto scatter = [&](Vec2 d) { return xx * d.x * d.x + 2 * xy * d.x * d.y + yy * d.y * d.y; };
    along_mm2 = scatter(along), across_mm2 = scatter(across);
    for (const Vec2 p : points)
      along_mm += std::abs(dot(along, p - mean)), across_mm += std::abs(dot(across, p - mean));
    along_known = along_mm2 >= floor_mm2, across_known = across_mm2 >= floor_mm2;
  }

  /// From the nearest point whose height is known: the mean, the line along which the tilt is known, or p itself. The
  /// plane there is off by at most this times the slope that is not known.
  [[nodiscard]] double distance_mm(Vec2 p) const {
    const Vec2 off = p - mean;
    return std::hypot(along_known ? 0.0 : dot(along, off), across_known ? 0.0 : dot(across, off));
  }
  /// An error of at most 1 in each height makes at most this of the least-squares plane over p.
  [[nodiscard]] double leverage(Vec2 p) const {
    const Vec2 off = p - mean;
    return 1 + (along_known ? std::abs(dot(along, off)) * along_mm / along_mm2 : 0.0) +
           (across_known ? std::abs(dot(across, off)) * across_mm / across_mm2 : 0.0);
  }
};

}  // namespace gantry
