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
constexpr int kSilentSteps = 2000;  // of about a cycle each; a host that stands still makes none

}  // namespace

Control::Control(cycle::Channels& channels, Feed& feed, Pump& pump, std::function<Error(const cycle::Event&)> describe)
    : channels_(channels), feed_(feed), pump_(pump), describe_(std::move(describe)) {
  feed_.listen({}, [this](const cycle::Event& event) { on_event(event); });
}

void Control::on_event(const cycle::Event& event) {
  if (event.kind == EventKind::Fault && latches(info(event.fault)) && !fault_) fault_ = describe_(event);
  if (event.kind == EventKind::CommandDone || event.kind == EventKind::BlockDone || event.kind == EventKind::Touched)
    answers_.push_back(event);
}

void Control::step() {
  pump_.step();
  feed_.drain();
  silent_steps_ = latest().cycle == last_cycle_ ? silent_steps_ + 1 : 0;
  last_cycle_ = latest().cycle;
  if (poll_orders_) poll_orders_();
}

Result<void> Control::alive() const {
  if (silent_steps_ < kSilentSteps) return {};
  return fail(Fault::LoopDied,
              fmt::format("{}: no cycle was heard of for {} ms", info(Fault::LoopDied).text, silent_steps_));
}

void Control::post(cycle::Command command) {
  command.id = next_id_++;
  while (!channels_.commands.push(command) && alive()) step();
}

void Control::abort(Error why) {
  if (aborted_) return;
  aborted_ = std::move(why);
  channels_.stop_now.store(true, std::memory_order_release);
}

void Control::begin() {
  fault_.reset();
  forget_abort();
}

void Control::forget_abort() {
  aborted_.reset();
  channels_.stop_now.store(false, std::memory_order_release);
}

bool Control::standing() const {
  const State s = latest().state;
  return s != State::Running && s != State::Stopping && s != State::Homing && s != State::Enabling;
}

Result<void> Control::ended() const {
  if (auto dead = alive(); !dead) return dead;
  if (fault_) return tl::unexpected(*fault_);
  if (aborted_) return tl::unexpected(*aborted_);
  return {};
}

/// The machine is braking: a wait is over when it stands, so that whoever goes on finds it at rest. An abort has been
/// taken only when the loop says so: before, the machine may stand on hold, or be about to start a block.
void Control::come_to_rest() {
  const bool asked = aborted_.has_value();
  const cycle::Command last{.kind = CommandKind::Abort, .id = next_id_++};  // behind everything that was sent
  while (asked && !channels_.commands.push(last) && alive()) step();
  const auto taken = [&] {
    return !asked || std::any_of(answers_.begin(), answers_.end(), [&](const cycle::Event& e) {
      return e.kind == EventKind::CommandDone && e.id == last.id && e.cycle <= latest().cycle;
    });
  };
  const CycleIndex give_up = latest().cycle + static_cast<CycleIndex>(kStopTimeout_s * 1000);
  while (alive() && latest().cycle < give_up && !(taken() && standing())) step();
}

Result<void> Control::wait(const std::function<bool()>& done, double timeout_s, Error late) {
  const CycleIndex begin = latest().cycle;
  const auto limit = static_cast<CycleIndex>(timeout_s * 1000.0);
  while (!done()) {
    if (!ended()) {
      come_to_rest();
      auto why = ended();
      channels_.stop_now.store(false, std::memory_order_release);
      return why;
    }
    if (latest().cycle - begin > limit) return tl::unexpected(std::move(late));
    step();
  }
  return {};
}

Result<void> Control::pass(double seconds) {
  const CycleIndex until = latest().cycle + static_cast<CycleIndex>(seconds * 1000.0 + 0.5);
  return wait([&] { return latest().cycle >= until; }, seconds + 3600, {});
}

Result<void> Control::command(cycle::Command command, double timeout_s) {
  command.id = next_id_++;
  answers_.clear();
  while (!channels_.commands.push(command) && alive()) step();
  const cycle::Event* answer = nullptr;
  const auto answered = [&] {
    for (const cycle::Event& e : answers_)
      if (e.kind == EventKind::CommandDone && e.id == command.id) answer = &e;
    return answer != nullptr;
  };
  if (auto r =
          wait(answered, timeout_s,
               Error{Fault::TransitionTimeout, fmt::format("the machine did not answer within {:g} s", timeout_s), ""});
      !r)
    return r;
  if (answer->fault != Fault::None) return tl::unexpected(describe_(*answer));
  return wait([&, cycle = answer->cycle] { return latest().cycle >= cycle; }, 1, {});
}

Result<Played> Control::play(std::uint32_t block, std::span<const motion::Segment> segments, bool clamp_may_be_open) {
  answers_.clear();
  std::size_t pushed = 0;
  const auto feed_ring = [&] {
    while (pushed < segments.size() && channels_.segments.push(segments[pushed])) ++pushed;
  };
  feed_ring();
  const cycle::Command start{.kind = CommandKind::StartBlock, .block = block, .clamp_may_be_open = clamp_may_be_open};
  if (auto r = command(start, 5.0); !r) return tl::unexpected(r.error());
  Played played;
  bool over = false;
  std::optional<cycle::Event> stopped;
  const auto look = [&] {
    feed_ring();
    for (const cycle::Event& e : answers_) {
      if (e.kind == EventKind::Touched) played.touched = true, played.touched_at = e.value;
      if (e.kind != EventKind::BlockDone || e.block != block) continue;
      over = true, played.end = e.cycle;
      if (e.fault != Fault::None) stopped = e;
    }
    return over && latest().cycle >= played.end;
  };
  constexpr double kNoLimit_s = 1e9;  // a held block may wait for its operator
  if (auto r = wait(look, kNoLimit_s, {}); !r) return tl::unexpected(r.error());
  if (stopped) return tl::unexpected(fault_ ? *fault_ : describe_(*stopped));  // the fault's own event knows more
  return played;
}

}  // namespace gantry::run
