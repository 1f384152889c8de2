// Where a stop has cut a bead: the valve shuts a known time after its command, while the tool still brakes, and the
// drives are a known time behind the loop's path.
//   CutWatch watch(machine);   watch.begin();   each snapshot of the block: watch.see({s.cycle, s.along_block_mm,
//   s.valve_cut}); auto laid = laid_part(block.segments(), before, *watch.shut_at(close_lead_s));
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
  bool plays = true;  ///< and is not on hold
  bool valve_open = false;
};

/// Where along the block the tool was when the valve had shut, and for how long it had stood there.
struct ShutAt {
  double along_block_mm = 0;  ///< along the block
  double stood_s = 0;         ///< how long it had stood there
};

class CutWatch {
 public:
  explicit CutWatch(const config::Machine& machine);

  /// Of a new block.
  void begin();
  void see(const BlockCycle& cycle);
  /// A stop has shut the valve where the tool stood, and has ended the block in the same cycle.
  void see_cut(CycleIndex cycle);
  /// Where along the block the tool was when the valve had shut; nothing where no stop has cut it, neither its command
  /// nor the way that the tool had to go until it was shut.
  [[nodiscard]] std::optional<ShutAt> shut_at(double close_lead_s) const;
  /// For how long something came out of the valve, by its leads, before a stop had cut it; 0 or less: nothing did.
  /// Nothing: no stop has cut it.
  [[nodiscard]] std::optional<double> flowed_s(double open_lead_s, double close_lead_s) const;
  /// For how long the block has played since the tool came to where it is: what is gone of a dwell there.
  [[nodiscard]] double stands_s() const { return static_cast<double>(stands_) * tick_s_; }

 private:
  double tick_s_;
  int delay_ticks_;  ///< of the drives behind the path
  std::deque<BlockCycle> seen_;
  CycleIndex opened_ = 0;  ///< by the last command
  std::optional<CycleIndex> cut_;
  std::optional<CycleIndex> shut_;   ///< as planned, by its command
  std::optional<CycleIndex> stops_;  ///< behind that
  CycleIndex stands_ = 0;            ///< cycles
  double last_mm_ = 0;               ///< along the block, of the last cycle
};

/// Of a bead, along its motion.
struct Laid {
  double mm = 0;       ///< that lie; 0 where the valve had not opened yet
  double all_mm = 0;   ///< after which the valve would have shut as planned
  double stood_s = 0;  ///< of a standstill at its start with the valve open
};
/// What lies of a bead of this block whose valve shut there. `before` is what lay when the block began. Nothing: the
/// block has no such bead.
std::optional<Laid> laid_part(const std::deque<motion::Segment>& segments, const LaidPart& before, const ShutAt& shut);

}  // namespace gantry::job
