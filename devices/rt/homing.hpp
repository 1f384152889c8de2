// A drive's own homing (mode 6), one cycle at a time. Method, speeds and acceleration are in the drive already
// (profiles/homing_objects.hpp); this starts it, bounds it in time and travel, and comes back to CSP standing, with the
// target on the actual position.
//   run.start(limits, drive.feedback());
//   drive.write(outputs, run.step(drive.feedback()));           // every cycle while run.busy()
//   if (run.phase() == HomingRun::Phase::Done) drive.set_reference(home_offset, axis.homing->position);
// Done means bits 10 and 12 (an idle AMD530B sets bit 10 alone, manual 6.2); bit 13 is an error. Both must be seen to
// be new: bits of an earlier homing do not count. An axis that stood at the edge of its switch may be done before any
// frame has shown the switch: it is led off a little (lead_step) and homed once more.
// Pure state; lives in the RT loop.
#pragma once
#include <cstdint>

#include "core/clock.hpp"
#include "core/fault.hpp"
#include "devices/rt/drive.hpp"
#include "devices/rt/home_edge.hpp"
#include "devices/rt/homing_guard.hpp"

namespace gantry::devices {

struct HomingLimits {
  std::int64_t timeout_cycles = 60'000;
  std::int64_t travel_counts = 0;  ///< from the start; 0: not bounded
  Time cycle = milliseconds(1);    ///< between two calls of step()
  HomingRules rules{};             ///< switches and speed that are watched meanwhile
  std::int64_t home_counts = 0;    ///< 607Ch: what the drive counts at its edge
  std::int64_t near_counts = 0;    ///< of it, within which an axis stands that has come home; 0: not watched
  std::int64_t edge_counts = 0;    ///< what it counts may be so far off the edge that 60FDh has shown; 0: not watched
};

class HomingRun {
 public:
  enum class Phase : std::uint8_t {
    Idle,
    EnterMode,  ///< until the drive shows mode 6
    Search,     ///< start bit set
    Settle,     ///< start bit cleared, until it stands
    LeaveMode,  ///< until the drive shows CSP again
    LeadOff,    ///< a short distance back from its switch, by targets; then it is searched once more
    Done,
    Failed,  ///< fault(): HomingFailed, HomingTimeout, HomingWrongLimit, HomingTooFast, HomingSwitchStuck, or the
             ///< drive's own
  };

  void start(const HomingLimits& limits, const Feedback& feedback) noexcept;
  /// `elapsed`: cycles since the last call, more than 1 after a stall. `may_search`: the other side of its axis is
  /// ready, too; without that its search does not begin.
  DriveCommand step(const Feedback& feedback, std::int64_t elapsed = 1, bool may_search = true) noexcept;
  /// Ends it early (an abort): stops, comes back to CSP and ends as Failed with `why`. One that is Done fails, too:
  /// what it has found no longer holds (the counter jumped while other axes were still homing). A drive that is not
  /// heard of for 100 ms is not waited for.
  void cancel(Fault why) noexcept;

  [[nodiscard]] bool busy() const noexcept {
    return phase_ != Phase::Idle && phase_ != Phase::Done && phase_ != Phase::Failed;
  }
  /// It was ended early, and the drive is to stop by itself.
  [[nodiscard]] bool stopping() const noexcept { return phase_ == Phase::Settle && fault_ != Fault::None; }
  /// Its search may begin, or has begun.
  [[nodiscard]] bool ready() const noexcept { return ready_ || phase_ > Phase::EnterMode; }
  /// So many counts in so many cycles are no motion: the drive has set its counter at its edge.
  [[nodiscard]] bool is_jump(std::int64_t step, std::int64_t cycles) const noexcept;
  /// Counts of the search so far. That the drive sets its counter anew at the edge is no motion.
  [[nodiscard]] std::int64_t moved() const noexcept { return moved_; }
  /// While it leads off: counts by which the target moves in this cycle.
  [[nodiscard]] int lead_step() const noexcept { return lead_step_; }
  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  [[nodiscard]] Fault fault() const noexcept { return fault_; }

 private:
  void enter(Phase phase) noexcept { phase_ = phase, in_phase_ = 0; }
  void watch_search(const Feedback& f) noexcept;
  [[nodiscard]] bool at_the_edge() const noexcept;
  [[nodiscard]] bool counter_is_dead() const noexcept;
  void lead_off(const Feedback& f) noexcept;
  void leave(const Feedback& f) noexcept;
  [[nodiscard]] std::int64_t off_edge(const Feedback& f) const noexcept;
  [[nodiscard]] bool stands(const Feedback& f) noexcept;

  Phase phase_ = Phase::Idle;
  Fault fault_ = Fault::None;
  HomingLimits limits_;
  HomingGuard guard_;
  HomeEdge edge_;
  Counts start_, last_;
  bool counted_ = false;                 ///< 6064h has moved in a search
  std::int64_t moved_ = 0, unseen_ = 0;  ///< cycles since the last that was heard of
  std::int64_t phase_cycles_ = 1000, stands_cycles_ = 20, silent_cycles_ = 100;
  std::int64_t cycles_ = 0, in_phase_ = 0;
  int still_ = 0;         ///< cycles without a count of motion
  bool led_off_ = false;  ///< it is to be led off, or was, and is searched for once more
  std::int64_t led_ = 0;  ///< counts
  int lead_step_ = 0;
  bool ready_ = false;        ///< in mode 6, and what the drive shows from here on is of this run
  bool seen_undone_ = false;  ///< neither "done" nor "error" was seen, in mode 6: what comes now is of this run
};

}  // namespace gantry::devices
