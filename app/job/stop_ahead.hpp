// How far a stop on the path takes, known before it is asked for: from what the loop shows and the block that plays, by
// the loop's own rules (motion/rt/pace.cpp).
//   StopAhead ahead(limits);   if (const auto mm = ahead.from(plays, {along_block_mm, path_speed, path_acceleration}))
//   ...
// It holds for a stop that the loop begins within kReaction ticks of that. Off the RT side: 0.1 ms or so.
#pragma once
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>

#include "app/job/path_mm.hpp"
#include "motion/rt/rate_change.hpp"
#include "motion/types.hpp"

namespace gantry::job {

/// The block that plays, and how much of it the loop has been given: what it plays is among the last of that.
struct Plays {
  const std::deque<motion::Segment>* block = nullptr;  ///< null: nothing plays
  std::size_t fed = 0;                                 ///< segments
  double fed_mm = 0;                                   ///< of path, as Snapshot::along_block_mm counts
};

/// Of the tool on its path.
struct OnPath {
  double along_block_mm = 0;  ///< from the block's beginning
  double speed_mm_s = 0;
  double acceleration_mm_s2 = 0;  ///< as the last cycle shows it
};

class StopAhead {
 public:
  static constexpr int kReaction = 3;

  explicit StopAhead(const motion::Limits& limits);

  /// mm along the path to where the tool stands, at most; nothing where it stands, or where that is too long to find.
  [[nodiscard]] std::optional<double> from(const Plays& plays, const OnPath& now);

 private:
  [[nodiscard]] double on_line(const motion::Segment& line, double s_mm, const OnPath& now) const;
  [[nodiscard]] std::optional<double> on_pieces(const std::deque<motion::Segment>& block, std::size_t first,
                                                double s_mm, const OnPath& now);
  // In planned time, from the beginning of the first piece of the ring:
  [[nodiscard]] std::optional<double> stands_at_s(double now_s, double rate);
  [[nodiscard]] double gone_mm(double planned_s) const;
  [[nodiscard]] AxisVec place(double planned_s) const;

  motion::Limits limits_;
  std::unique_ptr<motion::SegmentRing>
      ring_;  ///< pieces from the one that plays to the next rest, and no farther than a stop goes
  motion::RateChange change_;
};

}  // namespace gantry::job
