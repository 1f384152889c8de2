// Points that jump to and fro about the way within the tolerance, as a digitiser or rounded coordinates leave them, are
// thinned out by more of the tolerance than others, so that the path follows the way and not the jumps.
//   Jitter jitter(measure, tolerance, share);   jitter.add(vertex, out); ...; jitter.finish(out);
// What does not jump goes through as it is. Memory and work for a vertex are bounded.
#pragma once
#include <optional>
#include <vector>

#include "motion/path/outline.hpp"

namespace gantry::motion {

class Jitter {
 public:
  /// share: of the tolerance, how far points that are left out may lie off the way.
  Jitter(const Measure& measure, double tolerance_mm, double share);

  void add(const Vertex& v, std::vector<Vertex>& out);
  /// The last vertex goes out; afterwards a new polyline may begin.
  void finish(std::vector<Vertex>& out);

 private:
  [[nodiscard]] double distance(const AxisVec& a, const AxisVec& b) const;
  [[nodiscard]] bool jumps(const AxisVec& next) const;
  void pass(bool jumps, std::vector<Vertex>& out);

  Measure measure_;
  double tolerance_mm_;
  Outline outline_;  ///< of what jumps
  bool jumping_ = false;
  double calm_mm_ = 0;             ///< of way, since the last jump
  std::optional<AxisVec> before_;  ///< the last but one vertex that has come
  std::optional<Vertex> last_;     ///< the last one, which has not gone out
};

}  // namespace gantry::motion
