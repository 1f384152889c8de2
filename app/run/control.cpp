#include "app/run/control.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace gantry::run {
namespace {

using cycle::CommandKind;
using cycle::EventKind;
using cycle::State;

constexpr double kStopTimeout_s = 10;
constexpr double kNoLimit_s = 1e9;  // what is held may wait for its operator
constexpr std::chrono::milliseconds kBreath{5};
constexpr Time kSilence = milliseconds(2000);  // in steps of about a cycle; a host that stands still makes none

}  // namespace

Control::Control(cycle::Channels& channels, Feed& feed, Pump& pump, Time period,
                 std::function<Error(const cycle::Event&)> describe)
    : channels_(channels),
      feed_(feed),
      pump_(pump),
      period_(period),
      describe_(std::move(describe)),
      in_flight_(channels) {
  feed_.listen([this](const cycle::Snapshot& snapshot) { on_snapshot(snapshot); },
               [this](const cycle::Event& event) { on_event(event); });
}

/// A feature that a hold stops on is not resumed by the loop, which keeps the valve shut and has no run-up: whoever
/// plays it plans the rest anew.
void Control::on_snapshot(const cycle::Snapshot& s) {
  if (playing_ == 0 && stopped() && s.cycle > fault_at_ && s.latched == Fault::None) fault_.reset();
  if (playing_ == 0 || s.block != playing_) return;
  const bool cut = s.valve_cut && (s.state == State::Holding || s.state == State::Held);
  const bool stands = s.state == State::Held && s.feature != motion::kTravel;
  if ((cut || stands) && !std::exchange(cut_, true)) hold_next_ = true;  // once: a resume may come while it brakes
}

void Control::on_event(const cycle::Event& event) {
  const bool cause = event.fault == Fault::SafetyChainOpen;  // of whatever the bus and the drives have said before
  if (event.kind == EventKind::Fault && latches(info(event.fault))) {
    if (!fault_ || cause || stopped()) fault_ = describe_(event), fault_at_ = event.cycle;
    if (stopped()) hold_next_ = true;
  }
  in_flight_.see(event);
  if (event.kind == EventKind::BlockDone || event.kind == EventKind::Touched) of_the_block_.push_back(event);
}

std::optional<double> Control::valve_shut_s() const {
  const auto open = feed_.valve_open_ns();
  if (!open) return std::nullopt;
  return static_cast<double>(latest().time_ns - *open) * 1e-9;
}

CycleIndex Control::cycles(double seconds) const { return cycles_in(seconds, period_); }

void Control::step() {
  in_flight_.hand_over();
  pump_.step();
  feed_.drain();
  follow_hold();
  silent_steps_ = latest().cycle == last_cycle_ ? silent_steps_ + 1 : 0;
  last_cycle_ = latest().cycle;
  if (poll_orders_) poll_orders_();
}

void Control::idle() {
  step();
  if (service_) service_();
}

void Control::see_valve_shut(double lag_s) {
  constexpr double kOnItsWay_s = 0.01;  // out to the station, to its sync, and a snapshot back
  const CycleIndex give_up = latest().cycle + 2 * cycles(lag_s + kOnItsWay_s);
  const auto seen = [&] {
    const auto shut_s = valve_shut_s();
    return !shut_s || (!valve_open() && *shut_s >= lag_s + kOnItsWay_s);
  };
  while (alive() && latest().cycle < give_up && !seen()) idle();
}

bool Control::breathe() {
  const auto now = std::chrono::steady_clock::now();
  if (now - breathed_ >= kBreath) {
    breathed_ = now;
    in_flight_.hand_over();
    feed_.drain();
    follow_hold();
    if (poll_orders_) poll_orders_();
  }
  return !aborting();
}

Result<void> Control::alive() const {
  const Time silence = silent_steps_ * period_;
  if (silence < kSilence) return {};
  return fail(Fault::LoopDied, fmt::format("{}: no cycle was heard of for {} ms", info(Fault::LoopDied).text,
                                           silence / milliseconds(1)));
}

Result<void> Control::not_crowded() const {
  if (!in_flight_.crowded()) return {};
  return fail(Fault::Refused, "the loop is behind with the orders before it; give this one once more");
}

std::optional<Result<void>> Control::answer(Request request) {
  const auto answer = in_flight_.answer(request);
  if (!answer) return std::nullopt;
  if (answer->fault == Fault::None) return Result<void>{};
  return Result<void>(tl::unexpected(words(*answer)));
}

Error Control::words(const cycle::Event& answer) const {
  if (answer.fault == Fault::Aborted && aborted_) return *aborted_;
  return fault_ && fault_->fault == answer.fault ? *fault_ : describe_(answer);  // the fault's own event knows more
}

void Control::abort(Error why) {
  if (aborted_) return;
  aborted_ = std::move(why);
  channels_.stop_now.store(true, std::memory_order_release);
}

void Control::hold(bool now) {
  if (hold_) in_flight_.forget(*hold_);
  hold_ = request({.kind = CommandKind::Hold, .value = now ? 1.0 : 0.0});
  hold_asked_ = latest().cycle;
  hold_taken_.reset();
  hold_next_ = hold_next_ || cut_;  // what plays is dropped in any case
}

void Control::follow_hold() {
  const auto answer = hold_ ? in_flight_.answer(*hold_) : std::nullopt;
  if (answer && answer->fault == Fault::None) hold_taken_ = answer->cycle;
  // An answer that has not come by then was lost with other events: what comes next is held in any case.
  constexpr double kAnswer_s = 1;
  const bool lost = hold_ && !answer && !hold_taken_ && latest().cycle - hold_asked_ > cycles(kAnswer_s);
  if (lost) in_flight_.forget(*hold_);
  const bool refused = lost || (answer && answer->fault != Fault::None);
  hold_next_ = hold_next_ || refused;
  if (refused || (hold_taken_ && *hold_taken_ <= latest().cycle)) hold_.reset(), hold_taken_.reset();
}

void Control::begin() {
  fault_.reset();
  end();
}

void Control::end() {
  aborted_.reset();
  hold_next_ = outlives_ = false;
  if (hold_) in_flight_.forget(*std::exchange(hold_, std::nullopt));
  hold_taken_.reset();
  channels_.stop_now.store(false, std::memory_order_release);
}

bool Control::standing() const {
  const State s = latest().state;
  return !row(s).moves && s != State::Enabling && s != State::Disabling;
}

Result<void> Control::ended() const {
  if (auto dead = alive(); !dead) return dead;
  if (fault_ && !(waits_ && stopped())) return tl::unexpected(*fault_);
  return not_aborted();
}

Result<void> Control::not_aborted() const {
  if (aborted_) return tl::unexpected(*aborted_);
  return {};
}

/// The machine is braking: a wait is over when it stands, so that whoever goes on finds it at rest. An abort has been
/// taken only when the loop says so: before, the machine may stand on hold, or be about to start a block.
void Control::come_to_rest(Stop stop) {
  std::optional<Request> last;
  if (stop == Stop::IsSent) last = request({.kind = CommandKind::Abort});  // behind everything that was sent
  std::optional<cycle::Event> answer;
  const auto taken = [&] {
    if (last && !answer) answer = in_flight_.answer(*last);
    return !last || (answer && answer->cycle <= latest().cycle);
  };
  const CycleIndex give_up = latest().cycle + cycles(kStopTimeout_s);
  while (alive() && latest().cycle < give_up && !(taken() && standing())) idle();
  if (last) in_flight_.forget(*last);
}

Result<void> Control::wait(const std::function<bool()>& done, double timeout_s, Error late) {
  const CycleIndex begin = latest().cycle;
  const CycleIndex limit = cycles(timeout_s);
  while (!done()) {
    if (auto why = ended(); !why) {
      come_to_rest(aborted_ ? Stop::IsSent : Stop::IsUnderWay);
      auto after = ended();  // it may know more by now
      return after ? why : after;
    }
    if (latest().cycle - begin > limit) {
      if (row(latest().state).moves) come_to_rest(Stop::IsSent);  // nobody waits for it any more
      return tl::unexpected(std::move(late));
    }
    idle();
  }
  return {};
}

Result<void> Control::pass(double seconds) {
  const CycleIndex until = latest().cycle + cycles(seconds);
  return wait([&] { return latest().cycle >= until; }, seconds + 3600, {});
}

Result<void> Control::command(const cycle::Command& command, double timeout_s) {
  const Request asked = request(command);
  std::optional<cycle::Event> answer;
  const Error late{Fault::TransitionTimeout, fmt::format("the machine did not answer within {:g} s", timeout_s), ""};
  const auto answered = wait([&] { return (answer = in_flight_.answer(asked)).has_value(); }, timeout_s, late);
  in_flight_.forget(asked);
  if (!answered) return answered;
  if (answer->fault != Fault::None) return tl::unexpected(words(*answer));
  return wait([&] { return latest().cycle >= answer->cycle; }, 1, {});
}

Result<void> Control::wait_for_resume(const std::function<bool()>& given_up) {
  std::optional<Error> stop;
  const auto torque_lost = [&] { return stop && !stopped() && latest().state == State::Disabled; };
  waits_ = true;
  const auto waited = wait(
      [&] {
        if (stopped()) stop = fault_;
        const bool on_hold = hold_next_ || hold_ || stopped();
        channels_.on_hold.store(on_hold, std::memory_order_relaxed);
        return torque_lost() || !on_hold || (given_up && given_up());
      },
      kNoLimit_s, {});
  waits_ = false;
  channels_.on_hold.store(false, std::memory_order_relaxed);
  if (!waited || !torque_lost()) return waited;
  stop->message += "; the drives have lost their torque meanwhile, so that the job cannot go on";
  return tl::unexpected(*stop);
}

Result<Played> Control::play(const job::ProvenBlock& block, cycle::Purpose purpose) {
  if (auto r = wait_for_resume(); !r) return tl::unexpected(r.error());
  return play_now(block, purpose);
}

Result<Played> Control::play_on_hold(const job::ProvenBlock& block) { return play_now(block, cycle::Purpose::Job); }

Result<Played> Control::play_now(const job::ProvenBlock& block, cycle::Purpose purpose) {
  if (!block.proved() && purpose != cycle::Purpose::Walk)
    return fail(Fault::Internal, "a motion that nothing proves was to be played as another than a walk");
  const auto& segments = block.segments();
  of_the_block_.clear();
  std::size_t pushed = 0;
  const auto feed_ring = [&] {
    while (pushed < segments.size() && channels_.segments.push(segments[pushed]))
      plays_.fed_mm += job::path_mm(segments[pushed++]);
    plays_.fed = pushed;
  };
  plays_ = {};
  feed_ring();
  Played played;
  bool dropping = false, held_again = false;
  const auto drop_when_held = [&] {
    if (latest().state == State::Held) {
      dropping = true;
      played.on = latest().feature;
      post({.kind = CommandKind::Abort});
    } else if (latest().state == State::Running && !held_again) {  // resumed before the cut was seen here
      held_again = true;
      hold_next_ = false;
      post({.kind = CommandKind::Hold, .value = 1});
    }
  };
  const bool on_hold = hold_next_;
  const cycle::Command start{.kind = CommandKind::StartBlock, .block = block.number(), .purpose = purpose};
  if (auto r = command(start, 5.0); !r) return tl::unexpected(r.error());
  if (!on_hold && std::exchange(hold_next_, false)) hold(true);  // ordered while the block was about to begin
  playing_ = block.number();
  plays_.block = &segments;
  cut_ = false;
  bool over = false;
  std::optional<cycle::Event> stop;
  const auto look = [&] {
    if (!dropping) feed_ring();
    if (cut_ && !dropping) drop_when_held();
    for (const cycle::Event& e : of_the_block_) {
      if (e.kind == EventKind::Touched) played.touched = true, played.touched_at = e.value;
      if (e.kind != EventKind::BlockDone || e.block != block.number()) continue;
      over = true, played.end = e.cycle;
      if (e.fault != Fault::None) stop = e;
    }
    return over && latest().cycle >= played.end;
  };
  const auto waited = wait(look, kNoLimit_s, {});
  playing_ = 0;
  plays_ = {};
  cut_ = false;
  if (!waited) return tl::unexpected(waited.error());
  if (dropping && stop && stop->fault == Fault::Aborted) {
    played.cut = true;
    return played;
  }
  if (stop) return tl::unexpected(fault_ ? *fault_ : describe_(*stop));  // the fault's own event knows more
  return played;
}

}  // namespace gantry::run
