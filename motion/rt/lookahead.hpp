// How fast the tool may leave each of the next segments, so that it can still stop before the end of the path that is
// known and keeps every speed bound ahead: a backward pass over what waits in the ring.
//   Lookahead ahead(ring);  ahead.update(block, override);  double v = ahead.v_end(0);   // 0: the segment that plays
// Lives in the loop; the window bounds its work.
#pragma once
#include <array>

#include "core/rt/ring.hpp"
#include "motion/profile/planner.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

using SegmentRing = rt::Ring<Segment, 1024>;

/// Bounds of s on a segment at an override; a touch is never faster than planned.
Bounds bounds_of(const Segment& s, double override_factor) noexcept;

/// True where the path rests at the segment's end by plan: it may have a corner there.
bool rests_after(const Segment& s) noexcept;

class Lookahead {
 public:
  static constexpr std::size_t kWindow = 128;  ///< beyond it the path counts as not known

  explicit Lookahead(SegmentRing& ring) noexcept : ring_(ring) {}

  /// Speeds of the window from the front of the ring. At override 1 never above the planned ones, so that re-planned
  /// motion comes back to the plan.
  void update(std::uint32_t block, double override_factor) noexcept;

  /// Allowed speed at the end of the i-th waiting segment, as of the last update; 0 beyond the window.
  [[nodiscard]] double v_end(std::size_t i) const noexcept { return i < size_ ? v_end_[i] : 0; }

 private:
  SegmentRing& ring_;
  std::array<double, kWindow> v_end_{};
  std::size_t size_ = 0;
};

}  // namespace gantry::motion
