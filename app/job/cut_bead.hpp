// Where a stop has cut a bead: the valve shuts a known time after its command, while the tool still brakes, and the
// drives are a known time behind the loop's path.
//   CutWatch watch(machine);   watch.begin();   each snapshot of the block: watch.see({s.cycle, s.along_block_mm,
//   s.valve_cut}); auto laid = laid_part(block.segments(), feature, *watch.shut_at_mm(material.valve_close_lead),
//   before_mm);
#pragma once
#include <cstdint>
#include <deque>
#include <optional>

#include "app/job/job_state.hpp"
#include "config/machine.hpp"
#include "core/clock.hpp"
#include "motion/types.hpp"

namespace gantry::job {

/// One cycle of a block.
struct BlockCycle {
  CycleIndex cycle = 0;
  double along_block_mm = 0;  ///< length of path from the block's start, as planned
  bool valve_cut = false;
};

class CutWatch {
 public:
  explicit CutWatch(const config::Machine& machine);

  /// Of a new block.
  void begin();
  void see(const BlockCycle& cycle);
  /// Where along the block the tool was when the valve had shut; nothing where no stop has cut it.
  [[nodiscard]] std::optional<double> shut_at_mm(double close_lead_s) const;

 private:
  double tick_s_;
  int delay_ticks_;  ///< of the drives behind the path
  std::deque<BlockCycle> seen_;
  std::optional<CycleIndex> cut_;
};

/// Of a bead, along its motion.
struct Laid {
  double mm = 0;      ///< that lie; 0 where the valve had not opened yet
  double all_mm = 0;  ///< after which the valve would have shut as planned
};
/// What lies of a bead of this block whose valve shut there. `before_mm` of it lay when the block began. Nothing: the
/// block has no such bead.
std::optional<Laid> laid_part(const std::deque<motion::Segment>& segments, std::size_t feature, double shut_at_mm,
                              double before_mm);

}  // namespace gantry::job
