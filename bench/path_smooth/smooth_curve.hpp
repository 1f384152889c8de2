// Seeded smooth curves whose radii are at least `least_radius_mm` everywhere: sines, ellipses, Lissajous figures,
// closed Fourier curves, spirals, helices, curves of wandering curvature, lines and arcs, rounded rectangles.
//   const SmoothCurve curve = draw_curve(seed, 10.8);   // {kind, dense}
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace gantry::bench {

using Point = std::array<double, 3>;

struct SmoothCurve {
  std::string kind;
  std::vector<Point> dense;   ///< along it, so near to each other that chords are as good as the curve
  std::vector<Point> chords;  ///< some of them, 0.1 to 1 mm apart: the polyline that is planned
};

SmoothCurve draw_curve(std::uint64_t seed, double least_radius_mm);

}  // namespace gantry::bench
