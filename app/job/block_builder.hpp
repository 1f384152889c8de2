// Collects the segments of one block. Every addition is certified before it is taken.
//   BlockBuilder builder(limits, scene, number, from);   builder.straight(to, rules);   return builder.finish();
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "motion/path/moves.hpp"
#include "motion/plan/find_path.hpp"
#include "motion/plan/scene.hpp"
#include "motion/types.hpp"

namespace gantry::job {

struct PlannedBlock {
  std::vector<motion::Segment> segments;
  AxisVec end{};                      ///< where the axes rest, if nothing ends it earlier
  double duration_s = 0;              ///< nominal
  double minimum_clearance_mm = 1e9;  ///< over all certified motions
  std::size_t motions = 0;            ///< that were certified
};

class BlockBuilder {
 public:
  /// Limits and scene outlive it.
  BlockBuilder(const motion::Limits& limits, const motion::Scene& scene, std::uint32_t block, const AxisVec& from)
      : limits_(limits), scene_(scene), block_(block), at_(from) {}

  /// A way that is free, straight or over what stands there.
  Result<void> travel(const AxisVec& to, const motion::PathRules& rules);
  /// Straight, where a detour would make no sense (down to the surface, up from it) or is not wanted.
  Result<void> straight(const AxisVec& to, const motion::PathRules& rules, double v_cap = motion::kNoCap);
  /// A polyline that is about to be taken; `corner_mm` is how far its blends leave the corners.
  Result<void> prove(std::span<const AxisVec> way, const motion::PathRules& rules, double corner_mm = 0);
  /// Segments that were proved.
  void take(std::span<const motion::Segment> segments, const AxisVec& end, std::uint32_t feature = motion::kTravel);
  [[nodiscard]] PlannedBlock finish();

  [[nodiscard]] const AxisVec& at() const { return at_; }

 private:
  void count(const motion::Certificate& certificate, const motion::PathRules& rules);

  const motion::Limits& limits_;
  const motion::Scene& scene_;
  std::uint32_t block_;
  AxisVec at_;
  PlannedBlock out_;
};

}  // namespace gantry::job
