// The run thread's hand on the loop: sends a command or a block, lets time pass, and comes back with what became of it.
//   control.command({.kind = CommandKind::Enable}, 5.0);        control.play(block);
//   const Request r = control.request({.kind = CommandKind::Reset});   ... if (auto done = control.answer(r)) ...
// Waiting drains the feed, polls for orders (hold, abort ...) and ends at a latched fault, so the code that
// uses it reads in the order it happens. A step never steps again: orders that come in within it are put in flight
// (app/run/in_flight.hpp), and what takes several steps (fetching a station's mail) is a service, which runs between
// two steps.
#pragma once
#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "app/cycle/channels.hpp"
#include "app/job/proven_block.hpp"
#include "app/job/stop_ahead.hpp"
#include "app/run/feed.hpp"
#include "app/run/in_flight.hpp"
#include "app/run/pump.hpp"
#include "config/machine.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"
#include "motion/types.hpp"

namespace gantry::run {

/// How a block ended.
struct Played {
  bool touched = false;
  double touched_at = 0;  ///< coordinate of the probe's axis, mm
  bool cut = false;       ///< a hold has stopped it on a feature: the axes stand, and the rest of the block is dropped
  std::uint32_t on = motion::kTravel;  ///< that feature; kTravel: the valve was open ahead of it
  CycleIndex end = 0;
};

class Control {
 public:
  /// `describe` turns a fault event into words (which axis, the drive's own text). `period`: the machine's cycle.
  Control(cycle::Channels& channels, Feed& feed, Pump& pump, Time period,
          std::function<Error(const cycle::Event&)> describe);

  /// Called in every step: the place where orders of operators come in. It must not wait for the machine.
  void on_step(std::function<void()> poll_orders) { poll_orders_ = std::move(poll_orders); }
  /// Called between the steps of every wait. It may step(), and nothing else of this.
  void serve_by(std::function<void()> service) { service_ = std::move(service); }

  /// Sends and waits until the loop has done it. Fault of the refusal, or TransitionTimeout after `timeout_s` of
  /// machine time.
  Result<void> command(const cycle::Command& command, double timeout_s);
  /// Sends and does not wait (hold, resume, override); no time passes in it.
  void post(const cycle::Command& command) {
    if (command.kind == cycle::CommandKind::Override) ordered_override_ = command.value;
    in_flight_.post(command);
  }
  /// The last override that was posted, also where the loop has not taken it yet.
  [[nodiscard]] double ordered_override() const { return ordered_override_; }
  /// The same, and keeps the answer for whoever asks for it.
  Request request(const cycle::Command& command) { return in_flight_.ask(command); }
  /// Nothing as long as it has not come; once told, it is forgotten.
  std::optional<Result<void>> answer(Request request);
  /// Plays one block to its end. A hold makes it wait, also before it begins; one that stops on a feature ends
  /// it, and holds what comes next. An abort or a fault ends it with an error when the machine stands.
  Result<Played> play(const job::ProvenBlock& block, cycle::Purpose purpose = cycle::Purpose::Job);
  /// While this is on, until end(): a fault that can be outlived (Clear::Resume) ends what plays with its error, as any
  /// other does, and puts what comes next on hold. It is over when a reset has cleared it.
  void outlive_stops(bool yes) { outlives_ = yes; }
  [[nodiscard]] bool outlives_stops() const { return outlives_; }
  /// Such a fault has stopped what played, and no reset has cleared it.
  [[nodiscard]] bool stopped() const { return outlives_ && fault_ && outlived(info(fault_->fault)); }
  /// Waits for the resume of what is on hold, or until `given_up` says so. An error, too, when the drives have lost
  /// their torque meanwhile.
  Result<void> wait_for_resume(const std::function<bool()>& given_up = {});
  /// A hold has stopped the block that plays on a feature: it is dropped as soon as the axes stand.
  [[nodiscard]] bool cut() const { return cut_; }
  [[nodiscard]] const job::Plays& plays() const { return plays_; }
  /// A block that is played while what comes next is on hold.
  Result<Played> play_on_hold(const job::ProvenBlock& block);
  /// Holds what plays; where that has ended before the loop hears of it, what comes next. `now`: also within a feature
  /// whose end is near.
  void hold(bool now);
  /// What has become of the last one is not to be seen yet.
  [[nodiscard]] bool hold_is_on_its_way() const { return hold_.has_value(); }
  /// The next block waits until it is released.
  void hold_next(bool wait) { hold_next_ = wait; }
  [[nodiscard]] bool holds_next() const { return hold_next_; }
  /// Lets time pass until `done`; Error `late` after `timeout_s` of machine time, and what moves then is stopped first.
  Result<void> wait(const std::function<bool()>& done, double timeout_s, Error late);
  /// Lets `seconds` of machine time pass.
  Result<void> pass(double seconds);
  /// One step without looking for faults (shutting down).
  void step();
  /// The same, and the service behind it.
  void idle();
  /// Until what the valve was told last has happened on its board, `lag_s` and the way there after it shut. It is not
  /// waited for a valve that stays open, or a loop that has died.
  void see_valve_shut(double lag_s);
  /// Between two pieces of long work while the machine stands: what the loop has said is read and orders come in, every
  /// few milliseconds. No time passes. False: what is under way was aborted, and the work with it.
  bool breathe();
  /// Fault::LoopDied when the loop has not told anything for so many steps that it hangs.
  [[nodiscard]] Result<void> alive() const;

  /// The loop is behind with what was sent: Fault::Refused, for orders that can wait.
  [[nodiscard]] Result<void> not_crowded() const;

  [[nodiscard]] const cycle::Snapshot& latest() const { return feed_.latest(); }
  [[nodiscard]] double path_acceleration() const { return feed_.path_acceleration(); }
  /// As it was last told.
  [[nodiscard]] bool valve_open() const { return (latest().outputs & config::bit(config::Output::Valve)) != 0; }
  /// For how long the valve has been shut, s; nothing: it was never open since this bus is up.
  [[nodiscard]] std::optional<double> valve_shut_s() const;
  /// So many cycles of this machine, rounded to the nearest.
  [[nodiscard]] CycleIndex cycles(double seconds) const;
  /// The first latched fault since begin(), in words; any other takes the place of one that is outlived.
  [[nodiscard]] const std::optional<Error>& fault() const { return fault_; }
  /// A new undertaking: what ended the last one is forgotten.
  void begin();
  /// From any order: nothing begins to move any more, and the running wait ends with `why` once the machine stands. It
  /// holds until end().
  void abort(Error why);
  [[nodiscard]] bool aborting() const { return aborted_.has_value(); }
  /// What ends every wait: the loop has died, a fault is latched, an abort is pending.
  [[nodiscard]] Result<void> ended() const;
  /// The abort that is pending, as an error.
  [[nodiscard]] Result<void> not_aborted() const;
  /// The undertaking is over, and what was aborted with it: the next one is not concerned.
  void end();

 private:
  void on_event(const cycle::Event& event);
  void on_snapshot(const cycle::Snapshot& snapshot);
  Result<Played> play_now(const job::ProvenBlock& block, cycle::Purpose purpose);
  void follow_hold();
  enum class Stop { IsUnderWay, IsSent };
  void come_to_rest(Stop stop);
  [[nodiscard]] bool standing() const;
  [[nodiscard]] Error words(const cycle::Event& answer) const;

  cycle::Channels& channels_;
  Feed& feed_;
  Pump& pump_;
  Time period_;
  std::function<Error(const cycle::Event&)> describe_;
  std::function<void()> poll_orders_, service_;
  double ordered_override_ = 1;
  InFlight in_flight_;
  std::optional<Error> fault_, aborted_;
  CycleIndex fault_at_ = 0;
  bool outlives_ = false;                   ///< an undertaking that goes on after a stop
  bool waits_ = false;                      ///< for a resume: a stop does not end that
  std::vector<cycle::Event> of_the_block_;  ///< touched, done: since it began to play
  bool hold_next_ = false;
  std::optional<Request> hold_;           ///< until it is seen what became of it
  CycleIndex hold_asked_ = 0;             ///< in this cycle
  std::optional<CycleIndex> hold_taken_;  ///< by the loop, in this cycle
  std::uint32_t playing_ = 0;             ///< number of the block
  job::Plays plays_;
  bool cut_ = false;  ///< a hold has stopped it on a feature
  std::chrono::steady_clock::time_point breathed_{};
  CycleIndex last_cycle_ = 0;
  int silent_steps_ = 0;  ///< in which no cycle was told
};

}  // namespace gantry::run
