// A polyline with its superfluous points left out: what runs straight within the tolerance is one leg.
//   Outline outline(measure, tolerance);  outline.add(p, out); ...; outline.finish(out);      // out grows by vertices
// Vertices are points of the polyline; corners stay where they are. Memory and work for a point are bounded.
#pragma once
#include <vector>

#include "motion/path/curve.hpp"

namespace gantry::motion {

struct Vertex {
  AxisVec q{};
  double aside_mm = 0;  ///< no point that was left out before it is farther from the leg that ends here
  bool rest = false;    ///< the tool has to stand here
};

class Outline {
 public:
  Outline(const Measure& measure, double tolerance_mm) : measure_(measure), tolerance_mm_(tolerance_mm) {}

  /// aside_mm: how far from the leg to p points are that were left out before.
  void add(const AxisVec& p, double aside_mm, std::vector<Vertex>& out);
  /// The last point is a vertex; afterwards a new polyline may begin.
  void finish(std::vector<Vertex>& out);

 private:
  /// What the points between two of the waiting ones are from their chord.
  struct Chord {
    double aside_mm = 0;
    std::size_t farthest = 0;
    bool fits = false;
  };
  [[nodiscard]] Chord chord(std::size_t from, std::size_t to) const;
  [[nodiscard]] std::size_t best_break() const;
  void emit(std::size_t last, std::vector<Vertex>& out);
  bool thin_out();

  static constexpr std::size_t kMostWaiting = 64;
  Measure measure_;
  double tolerance_mm_;
  bool alone_ = true;            ///< no leg went out yet
  std::vector<Vertex> waiting_;  ///< [0] is the last vertex that went out
};

}  // namespace gantry::motion
