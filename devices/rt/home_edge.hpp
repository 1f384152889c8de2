// Where a reference switch opened or closed last while a drive looked for it, so that what the drive counts there
// afterwards can be held against it: its counter is set anew at that edge, or what is called home is not there.
//   HomeEdge edge(rules, within_counts, feedback);   each cycle of the search, and until it stands: edge.look(feedback,
//   elapsed); edge.agrees(counts from its edge that the drive shows now)
// Counts that the drive sets anew are no travel, as in HomingGuard.
#pragma once
#include <cstdint>

#include "devices/rt/homing_guard.hpp"

namespace gantry::devices {

class HomeEdge {
 public:
  HomeEdge() = default;
  /// `within`: how far the counter may be off the edge that was seen, counts; 0: not watched.
  HomeEdge(const HomingRules& rules, std::int64_t within, const Feedback& feedback) noexcept;

  /// `elapsed`: cycles since the last call.
  void look(const Feedback& feedback, std::int64_t elapsed) noexcept;
  /// `off`: how far from its edge the drive says that it stands. True where no edge was seen, or none can be.
  [[nodiscard]] bool agrees(std::int64_t off) const noexcept;

 private:
  std::uint8_t reference_ = 0, level_ = 0;
  std::int64_t within_ = 0, most_ = 0;  ///< counts; most_: in a cycle, more is a counter that was set
  Counts last_;
  std::int64_t travelled_ = 0;  ///< since that edge, counts
  bool seen_ = false;
};

}  // namespace gantry::devices
