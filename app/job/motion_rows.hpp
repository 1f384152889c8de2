// Proved motions as rows of a CSV file: which block and what for, the recipe's line, from where to where the axes go,
// and the pair that comes nearest on the way.
//   MotionRows rows(machine);   rows.heading();   rows.add(pieces, {block, "travel to dot 'a'", where, scene, ...});
#pragma once
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "motion/plan/certificate.hpp"

namespace gantry::job {

class MotionRows {
 public:
  explicit MotionRows(const config::Machine& machine);

  /// "block,motion,where,from_X_mm,...,to_X_mm,...,clearance_mm,head,standing,by_design_mm,..." with its line end.
  /// Axes that no coordinated motion takes along have no columns.
  [[nodiscard]] std::string heading() const;

  struct Proved {
    std::uint32_t block = 0;
    std::string motion, where;
    const motion::Scene& scene;
    std::span<const AxisVec> points;                ///< one more than motions
    const std::vector<motion::NearPairs>& nearest;  ///< of each motion
  };
  /// A row each, behind the last of `pieces`, which are cut at some dozen kilobytes.
  void add(std::deque<std::string>& pieces, const Proved& proved) const;

 private:
  struct Column {
    std::size_t axis = 0;
    std::string name;   ///< "X_mm", "C_deg"
    double factor = 1;  ///< from mm or rad
  };
  std::vector<Column> columns_;
};

}  // namespace gantry::job
