// Evens out the distances of vertices along gentle bends, so that a spline over them has an even curvature: points of
// an outline are as far apart as the tolerance lets them, give or take a chord of the input.
//   Spread spread(measure, tolerance);  spread.add(vertex, out); ...; spread.finish(out);
// Vertices move along a cubic through them. Starts, ends, corners and vertices beside much longer legs stay.
#pragma once
#include <deque>
#include <vector>

#include "motion/path/outline.hpp"

namespace gantry::motion {

class Spread {
 public:
  Spread(const Measure& measure, double tolerance_mm) : measure_(measure), most_aside_mm_(0.45 * tolerance_mm) {}

  void add(const Vertex& v, std::vector<Vertex>& out);
  void finish(std::vector<Vertex>& out);

 private:
  struct Knot {
    Vertex vertex;
    double at = 0;       ///< length of the legs up to it
    bool stays = true;   ///< known when the next one is
    double left_mm = 0;  ///< when it was moved: how far its old place is from the new legs
  };
  void settle(std::size_t k);
  [[nodiscard]] Vertex moved(std::size_t k);
  void put(std::size_t k, std::vector<Vertex>& out);
  [[nodiscard]] AxisVec tangent(std::size_t k) const;

  static constexpr std::size_t kReach = 3, kKept = 6;
  Measure measure_;
  double most_aside_mm_;
  std::deque<Knot> knots_;
  std::size_t done_ = 0;  ///< of knots_ that went out
};

}  // namespace gantry::motion
