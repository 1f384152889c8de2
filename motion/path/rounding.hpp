// From the vertices of an outline to a smooth path within the tolerance.
//   Rounding rounding(measure, tolerance);  rounding.add(vertex, out); ...; rounding.finish(out);
// Gentle bends are the fairest spline that the tolerance allows (fairing.hpp). A sharp corner is the cubic P - d d1
// (1-u)^3 + d d2 u^3: two motions that overlap, the one coming to rest while the other sets out. A reversal goes round
// its end within the tolerance. Without a tolerance every vertex is a rest. Works on a window of vertices: a spline
// that does not end in one goes on in the next.
#pragma once
#include <optional>
#include <vector>

#include "motion/path/curve.hpp"
#include "motion/path/fairing.hpp"
#include "motion/path/outline.hpp"

namespace gantry::motion {

inline constexpr double kSharp = 0.7;  ///< |d2 - d1| from which on a corner is sharp: about 40 degrees

class Rounding {
 public:
  /// by_vertex: what counts of a sharp corner is how far its vertex is from the path, sqrt(2) tolerances at most, and
  /// not how far the path is from the legs.
  Rounding(const Measure& measure, double tolerance_mm, bool by_vertex)
      : measure_(measure), tolerance_mm_(tolerance_mm), by_vertex_(by_vertex) {}

  /// False: no curve was found within the tolerance.
  [[nodiscard]] bool add(const Vertex& v, std::vector<Curve>& out);
  [[nodiscard]] bool finish(std::vector<Curve>& out);
  /// Vertices made rests because no curve stayed within the tolerance.
  [[nodiscard]] std::size_t rests() const { return rests_; }

 private:
  class Shape;
  struct Bent;
  void push(const Vertex& v);
  bool lay(bool last, std::vector<Curve>& out);
  bool bend(const Shape& shape, std::size_t next, const Bent& b, double until, double safe, std::vector<Curve>& out);
  bool rest_in(const Shape& shape, const Bent& b);
  void forget();

  // Vertices: what is worked on at a time, what has to be known beyond what is laid, and what stays behind it.
  static constexpr std::size_t kBatch = 96, kContext = 40, kKept = 10;
  Measure measure_;
  double tolerance_mm_;
  bool by_vertex_;
  std::vector<Vertex> seen_;   ///< the last two as they came: a reversal is known when its second leg is
  std::vector<Vertex> chain_;  ///< vertices with reversals split
  double laid_ = 0;            ///< length of the chain along which the path is out
  std::size_t hard_ = 0;       ///< the last vertex before it that is a rest or a sharp corner, or the chain's first
  std::optional<FairSpline> open_;  ///< the spline that ends there and goes on
  std::size_t rests_ = 0;
  std::size_t next_ = kBatch + kContext;  ///< vertices with which the next part is laid
};

}  // namespace gantry::motion
