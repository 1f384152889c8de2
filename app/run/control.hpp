// The run thread's hand on the loop: sends a command or a block, lets time pass, and comes back with what became of it.
//   control.command({.kind = CommandKind::Enable}, 5.0);        control.play(block, segments);
// Waiting drains the feed, polls for orders (hold, abort ...) and ends at the first latched fault, so the code that
// uses it reads in the order it happens.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "app/cycle/channels.hpp"
#include "app/run/feed.hpp"
#include "app/run/pump.hpp"
#include "core/error.hpp"
#include "motion/types.hpp"

namespace gantry::run {

/// How a block ended.
struct Played {
  bool touched = false;
  double touched_at = 0;  ///< coordinate of the probe's axis, mm
  CycleIndex end = 0;
};

class Control {
 public:
  /// `describe` turns a fault event into words (which axis, the drive's own text).
  Control(cycle::Channels& channels, Feed& feed, Pump& pump, std::function<Error(const cycle::Event&)> describe);

  /// Called in every waiting step: the place where orders of operators come in.
  void on_step(std::function<void()> poll_orders) { poll_orders_ = std::move(poll_orders); }

  /// Sends and waits until the loop has done it. Fault of the refusal, or TransitionTimeout after `timeout_s` of
  /// machine time.
  Result<void> command(cycle::Command command, double timeout_s);
  /// Sends and does not wait (hold, resume, override, abort).
  void post(cycle::Command command);
  /// Plays one block to its end. A hold makes it wait; an abort or a fault ends it with an error when the machine
  /// stands.
  Result<Played> play(std::uint32_t block, std::span<const motion::Segment> segments, bool clamp_may_be_open = false);
  /// Lets time pass until `done`; Error `late` after `timeout_s` of machine time.
  Result<void> wait(const std::function<bool()>& done, double timeout_s, Error late);
  /// Lets `seconds` of machine time pass.
  Result<void> pass(double seconds);
  /// One step without looking for faults (shutting down).
  void step();
  /// Fault::LoopDied when the loop has not told anything for so many steps that it hangs.
  [[nodiscard]] Result<void> alive() const;

  [[nodiscard]] const cycle::Snapshot& latest() const { return feed_.latest(); }
  /// The first latched fault since begin(), in words.
  [[nodiscard]] const std::optional<Error>& fault() const { return fault_; }
  /// A new job, or a reset: what ended the last one is forgotten.
  void begin();
  /// From any order: the running wait ends with `why` once the machine stands.
  void abort(Error why);
  /// What was aborted has ended: the next order is not concerned.
  void forget_abort();

 private:
  void on_event(const cycle::Event& event);
  void come_to_rest();
  [[nodiscard]] bool standing() const;
  Result<void> ended() const;

  cycle::Channels& channels_;
  Feed& feed_;
  Pump& pump_;
  std::function<Error(const cycle::Event&)> describe_;
  std::function<void()> poll_orders_;
  std::uint32_t next_id_ = 1;
  std::optional<Error> fault_, aborted_;
  std::vector<cycle::Event> answers_;  ///< events of the wait that runs
  CycleIndex last_cycle_ = 0;
  int silent_steps_ = 0;  ///< in which no cycle was told
};

}  // namespace gantry::run
