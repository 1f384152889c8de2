#include "motion/path/chords.hpp"

#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"

namespace gantry::motion {
namespace {

/// Into how many parts of equal u the whole curve has to be cut.
double parts_of(const Geometry& g) {
  double at_start = 0, at_end = 0;
  for (std::size_t k = 0; k < kCoefficients; k += 3) {
    const double begin = 2 * g.c[k + 1], end = begin + 6 * g.c[k + 2];
    at_start += begin * begin, at_end += end * end;
  }
  return std::sqrt(std::sqrt(std::max(at_start, at_end)) / (8 * kChord_mm));
}

AxisVec point_at(const Geometry& g, double u) {
  AxisVec q = g.from;
  for (std::size_t i = 0, k = 0; i < kMaxAxes; ++i)
    if ((g.moving >> i & 1u) != 0) q[i] += displacement(g, k++, u);
  return q;
}

}  // namespace

std::vector<AxisVec> chords(std::span<const Segment> segments) {
  std::vector<AxisVec> out;
  if (segments.empty()) return out;
  out.push_back(point(segments.front().geometry, 0));
  for (const Segment& segment : segments) {
    const Geometry& g = segment.geometry;
    if (g.degree == 0) continue;
    if (g.degree == 3) {
      const double from = parameter(g, 0), to = parameter(g, g.length);
      const double cuts = std::ceil(parts_of(g) * (to - from));
      for (double k = 1; k < cuts; ++k) out.push_back(point_at(g, from + (to - from) * k / cuts));
    }
    out.push_back(point(g, g.length));
  }
  return out;
}

double off_chords_mm(std::span<const Segment> segments) {
  const bool straight =
      std::all_of(segments.begin(), segments.end(), [](const Segment& s) { return s.geometry.degree < 2; });
  return straight ? 0 : kChord_mm;
}

}  // namespace gantry::motion
