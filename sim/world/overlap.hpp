// Do two solids overlap? The world's own judge of contact. FCL stays inside overlap.cpp, and of FCL only its boolean
// query, which was right in every case tried (its distance and continuous queries were not).
#pragma once
#include <memory>
#include <vector>

#include "sim/world/obstacles.hpp"

namespace gantry::sim {

/// A solid made ready for repeated questions.
class OverlapShape {
 public:
  explicit OverlapShape(const config::Shape& shape);
  ~OverlapShape();
  OverlapShape(OverlapShape&&) noexcept;
  OverlapShape& operator=(OverlapShape&&) noexcept;

 private:
  friend bool overlap(const OverlapShape&, const Solid&, const OverlapShape&, const Solid&);
  struct Geometry;
  std::unique_ptr<Geometry> geometry_;
};

/// Shapes at the solids' poses (their `shape` members are not looked at). mm.
bool overlap(const OverlapShape& a, const Solid& at_a, const OverlapShape& b, const Solid& at_b);

}  // namespace gantry::sim
