// One block of motion that was proved free before it may be played. Only BlockBuilder makes one, and it certifies every
// motion that it takes, so that whoever holds a ProvenBlock holds the proof. One exception: the walk of an axis while
// nothing knows where the head stands (BlockBuilder::unplaced) has none, which proved() tells: it is played as
// Purpose::Walk alone, whose length the loop bounds.
//   Result<ProvenBlock> block = planner.park(number, at);   control.play(*block);
#pragma once
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "app/job/nearest.hpp"
#include "app/job/run_up.hpp"
#include "core/axis_vec.hpp"
#include "core/breath.hpp"
#include "motion/types.hpp"

namespace gantry::job {

class ProvenBlock {
 public:
  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] bool proved() const { return proved_; }
  /// At least one; the last one ends the block. A deque: a block of 10^5 features is never moved as a whole.
  [[nodiscard]] const std::deque<motion::Segment>& segments() const { return segments_; }
  /// Where the axes rest, if nothing ends the block earlier.
  [[nodiscard]] const AxisVec& end() const { return end_; }
  [[nodiscard]] double duration_s() const { return duration_s_; }       ///< nominal
  [[nodiscard]] const Clearances& nearest() const { return nearest_; }  ///< over all certified motions
  [[nodiscard]] std::size_t motions() const { return motions_; }        ///< that were certified
  /// Of its beads, those that are not begun at their speed after a whole run-up.
  [[nodiscard]] const std::vector<RunUp>& run_ups() const { return run_ups_; }
  /// The same motions as rows of text (motion_rows.hpp), in pieces; none unless they were to be listed.
  [[nodiscard]] const std::deque<std::string>& rows() const { return rows_; }
  /// Along these motions, of which a second opinion was asked; 0: none was.
  [[nodiscard]] std::size_t poses() const { return poses_; }

 private:
  friend class BlockBuilder;
  friend void discard(ProvenBlock block, const Breath& breath);
  ProvenBlock() = default;

  std::uint32_t number_ = 0;
  bool proved_ = true;
  std::deque<motion::Segment> segments_;
  AxisVec end_{};
  double duration_s_ = 0;
  Clearances nearest_;
  std::size_t motions_ = 0, poses_ = 0;
  std::vector<RunUp> run_ups_;
  std::deque<std::string> rows_;
};

/// Frees a block that is over. 10^5 features are half a gigabyte: at once that takes a tenth of a second, so the breath
/// is asked meanwhile; its answer changes nothing.
void discard(ProvenBlock block, const Breath& breath);

}  // namespace gantry::job
