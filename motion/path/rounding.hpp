// From the vertices of an outline to a smooth path within the tolerance.
//   Rounding rounding(measure, tolerance);  rounding.add(vertex, out); ...; rounding.finish(out);
// A gentle bend is a cubic spline whose control points are the vertices and points on their legs: curvature rises and
// falls linearly with length. A sharp corner is the cubic P - d d1 (1-u)^3 + d d2 u^3: two motions that overlap, the
// one coming to rest while the other sets out. A reversal goes round its end within the tolerance. Without a tolerance
// every vertex is a rest. Works on a window of vertices; how a corner is rounded depends on its neighbours only.
#pragma once
#include <span>
#include <vector>

#include "motion/path/curve.hpp"
#include "motion/path/outline.hpp"

namespace gantry::motion {

class Rounding {
 public:
  Rounding(const Measure& measure, double tolerance_mm) : measure_(measure), tolerance_mm_(tolerance_mm) {}

  void add(const Vertex& v, std::vector<Curve>& out);
  void finish(std::vector<Curve>& out);

 private:
  void push(const Vertex& v);
  void emit(std::size_t first_leg, std::size_t end_leg, std::vector<Curve>& out) const;

  Measure measure_;
  double tolerance_mm_;
  std::vector<Vertex> seen_;   ///< the last two as they came: a reversal is known when its second leg is
  std::vector<Vertex> chain_;  ///< vertices with reversals split
  std::size_t done_ = 0;       ///< legs of chain_ that are out
};

}  // namespace gantry::motion
