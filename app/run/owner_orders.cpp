// Orders that are answered at once: which are taken stands in the table of states (app/cycle/machine_state.hpp), and
// what is under way may refuse besides.
#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "app/job/limits.hpp"
#include "app/job/stop_ahead.hpp"
#include "app/run/owner_parts.hpp"
#include "config/inputs.hpp"
#include "core/log.hpp"

namespace gantry::run {

using cycle::CommandKind;
using cycle::State;

Standing Owner::Parts::standing() const {
  if (!on_bus) return {.undertaking = undertaking, .on_bus = false};
  const State state = control().latest().state;
  const bool aborting = control().aborting();  // no resume lets go on what an abort ends
  const bool held = !aborting && (control().holds_next() || control().hold_is_on_its_way() || state == State::Held ||
                                  state == State::Holding);
  return {.state = state == State::Ready && held ? State::Held : state,
          .undertaking = undertaking,
          .held = held,
          .stopped = control().stopped(),
          .aborting = aborting};
}

Error Owner::Parts::refusal(OrderKind order) const { return {Fault::Refused, run::refusal(order, standing()), ""}; }

Result<void> Owner::Parts::in_words(Result<void> result) const {
  if (result || result.error().fault != Fault::Refused) return result;
  Standing now = standing();
  now.undertaking = Undertaking::None;  // which has not begun
  return fail(Fault::Refused, run::refusal(undertaking, now));
}

/// The valve is shut: there is nothing to finish.
std::string Owner::Parts::travel_hold_words() const {
  if (job && control().latest().feature != motion::kTravel)  // run-up, run-out, or what a hold has cut
    return fmt::format("holds now, at '{}'", job->runner.feature());
  const std::string next = job ? job->runner.heads_for() : "";
  return next.empty() ? "holds now, on its way" : fmt::format("holds now, on the way to '{}'", next);
}

Result<void> Owner::Parts::hold(bool now, OrderKind asked) {
  const State state = control().latest().state;
  if (control().aborting()) return tl::unexpected(refusal(asked));
  if (next(state, cycle::Cause::Hold)) {
    const std::optional<Ahead> ahead = job ? job->runner.ahead() : std::nullopt;
    now = now || state != State::Running || (ahead && ahead->left_s > machine.hold_within_s);
    order_said = !ahead ? travel_hold_words()
                 : now  ? fmt::format("holds now, {}", ahead->in())
                        : fmt::format("holds {} {:.2f} s", ahead->after(), ahead->left_s);
    on_bus->stop_ns = control().latest().time_ns;
    control().hold(now);
    return {};
  }
  order_said.clear();
  if (control().stopped()) order_said = "the job is stopped already; `reset`, then `resume` goes on";
  if (control().holds_next()) return {};
  // Before and between its motions an undertaking waits. Axes that home come to their end, and what is homed behind
  // them waits; an order to home says that it cannot be held as long as they do.
  const bool before = state == State::Ready || state == State::Enabling || state == State::Disabled ||
                      (state == State::Homing && undertaking == Undertaking::Job);
  if (!can_wait(undertaking) || !before) return tl::unexpected(refusal(asked));
  control().hold_next(true);
  on_bus->stop_ns = control().latest().time_ns;
  return {};
}

Result<void> Owner::Parts::resume() {
  if (control().aborting() || control().stopped() || control().hold_is_on_its_way())
    return tl::unexpected(refusal(OrderKind::Resume));
  // Braked on its run-up, a bead would begin too slowly: when the tool stands, it is approached anew.
  const cycle::Snapshot& s = control().latest();
  if (s.state == State::Holding && s.feature != motion::kTravel && !control().valve_open() && !control().cut())
    return tl::unexpected(refusal(OrderKind::Resume));
  const bool waits = control().holds_next();
  if (waits) control().hold_next(false);
  // A block that was cut is dropped when the axes stand: it is not for the loop to go on with.
  const bool stands = !control().cut() && next(control().latest().state, cycle::Cause::Resume);
  if (stands) control().post({.kind = CommandKind::Resume});
  button_holds = false;
  if (waits || stands || control().cut()) return {};
  return tl::unexpected(refusal(OrderKind::Resume));
}

/// Lowering is obeyed at once; what is dispensed is not made faster than it was begun.
Result<void> Owner::Parts::set_override(double factor) {
  order_said.clear();
  if (factor == 0) {
    auto held = hold(true, OrderKind::Override);
    if (!held) return held;
    const auto waits = std::exchange(raise_to, std::nullopt);
    if (!control().stopped()) order_said = "0 % " + (order_said.empty() ? "holds now" : order_said);
    if (waits) order_said += fmt::format("; {:.0f} % when the valve has shut is taken back", *waits * 100);
    return held;
  }
  const double by_materials = job ? job->runner.override_max() : 1;
  if (factor > std::max(machine.override_max, by_materials))
    return fail(
        Fault::Refused,
        fmt::format("this machine allows an override of at most {:.0f} % (`override_max` of its "
                    "file){}",
                    machine.override_max * 100,
                    !job ? std::string()
                         : fmt::format(", and what the job dispenses {:.0f} % (`override_max` of its materials)",
                                       by_materials * 100)));
  raise_to.reset();
  if (control().valve_open() && factor > control().latest().override_factor) {
    raise_to = factor;
    order_said = fmt::format("{:.0f} % when the valve has shut", factor * 100);
    return {};
  }
  control().post({.kind = CommandKind::Override, .value = factor});
  return {};
}

void Owner::Parts::raise_when_shut() {
  if (!raise_to || control().valve_open()) return;
  control().post({.kind = CommandKind::Override, .value = *std::exchange(raise_to, std::nullopt)});
}

/// While something moves or is to move, a reset could only be meant for what comes after. A job that stands on hold may
/// take one.
Result<void> Owner::Parts::reset() {
  const State state = control().latest().state;
  if (on_bus->reset) {
    on_bus->reset_answer = control().answer(*on_bus->reset);
    if (!on_bus->reset_answer)
      return fail(Fault::Refused, "'reset' is refused: one is under way already; wait for its answer");
  }
  const bool on_hold =
      state == State::Held || ((state == State::Ready || state == State::Stopped) && control().holds_next());
  const bool busy = undertaking != Undertaking::None && !(undertaking == Undertaking::Job && on_hold);
  if (control().aborting() || busy || !next(state, cycle::Cause::Reset))
    return tl::unexpected(refusal(OrderKind::Reset));
  on_bus->named.reset();
  on_bus->reset_answer.reset();
  on_bus->reset = control().request({.kind = CommandKind::Reset});
  return {};
}

void Owner::Parts::heed_buttons() {
  const Pressed pressed = on_bus->buttons.take();
  const auto do_it = [this](std::string_view button, const Result<void>& done) {
    if (!done) return log::warn("button {}: {}", button, done.error().message);
    acted(fmt::format("button {}", button));
  };
  if (pressed.hold && undertaking == Undertaking::None)
    on_bus->hold_pressed = true;
  else if (pressed.hold) {
    const Result<void> done = hold(false);
    button_holds = button_holds || done.has_value();
    do_it("hold", done);
  }
  if (pressed.reset) do_it("reset", reset());
  if (pressed.start_in_vain) log::warn("button start: a fault is latched; `reset` comes first");
  if (!pressed.start) return;
  const State state = control().latest().state;
  // Whoever is told that a stop was taken sees nothing move afterwards that was pressed before.
  const bool before_answer =
      on_bus->stop_ns && control().latest().time_ns - *on_bus->stop_ns < heard_within(machine.bus.cycle).count();
  if (before_answer)
    log::warn("button start: a stop came at the same time; press it again");
  else if (undertaking != Undertaking::None && in_setup())
    do_it("start", fail(Fault::SetupMode, std::string(info(Fault::SetupMode).text)));
  else if (control().holds_next() || state == State::Held || state == State::Holding)
    do_it("start", resume());
  else if (undertaking != Undertaking::None)
    // Beside a job it is pressed to go on.
    do_it("start", tl::unexpected(refusal(undertaking == Undertaking::Job ? OrderKind::Resume : OrderKind::Run)));
  else
    on_bus->start_pressed = true;
}

bool Owner::Parts::in_setup() const { return config::is_low(machine, control().latest().inputs, config::Input::Mode); }

/// Nothing but a dead loop ends the waiting: who aborts now, and what latches now, find the clamp told to open.
Result<void> Owner::Parts::release_part() {
  constexpr double kAnswer_s = 1;
  const std::uint32_t clamp = config::bit(config::Output::Clamp);
  control().post({.kind = CommandKind::SetOutputs, .mask = clamp, .bits = 0});
  const auto open = [&] { return (control().latest().outputs & clamp) == 0; };
  const CycleIndex give_up = control().latest().cycle + control().cycles(kAnswer_s);
  while (!open() && control().alive() && control().latest().cycle < give_up) control().idle();
  if (auto alive = control().alive(); !alive) return alive;
  if (open()) return {};
  return fail(Fault::TransitionTimeout, fmt::format("the clamp was not told to open within {:g} s", kAnswer_s));
}

void Owner::stop_was_taken() {
  if (parts_->on_bus) parts_->on_bus->stop_ns = latest().time_ns;
}

bool Owner::take_start() { return parts_->on_bus && std::exchange(parts_->on_bus->start_pressed, false); }

bool Owner::take_hold() { return parts_->on_bus && std::exchange(parts_->on_bus->hold_pressed, false); }

bool Owner::in_setup() const { return parts_->on_bus && parts_->in_setup(); }

Result<void> Owner::part_removed() {
  const Turn turn(*parts_, Undertaking::Part);
  if (!turn.taken()) return turn.refused();
  return parts_->release_part();
}

Result<void> Owner::order(const Order& order) {
  Parts& p = *parts_;
  if (!p.on_bus) {
    if (order.kind == OrderKind::Abort || order.kind == OrderKind::Status) return {};
    return tl::unexpected(p.refusal(order.kind));
  }
  const auto done = p.at_once(order);
  if (done && order.kind != OrderKind::Status)
    p.acted(order.kind == OrderKind::Override ? fmt::format("override {:.0f} %", order.value * 100)
                                              : std::string(name(order.kind)));
  return done;
}

Result<void> Owner::Parts::at_once(const Order& order) {
  const bool waits = order.kind != OrderKind::Abort && order.kind != OrderKind::Status;
  if (auto taken = control().not_crowded(); waits && !taken) return taken;
  switch (order.kind) {
    case OrderKind::Status: return {};
    case OrderKind::Hold: return hold(order.now);
    case OrderKind::Resume: return resume();
    case OrderKind::Reset: return reset();
    case OrderKind::Override: return set_override(order.value);
    case OrderKind::Abort:
      raise_to.reset();
      on_bus->stop_ns = control().latest().time_ns;
      on_bus->start_pressed = false;
      abort({Fault::Aborted, "the operator aborted it", ""});
      return {};
    default: return tl::unexpected(refusal(order.kind));
  }
}

/// What moves though nothing is under way any more is stopped all the same.
void Owner::Parts::abort(Error why) {
  if (undertaking != Undertaking::None)
    control().abort(std::move(why));
  else if (row(control().latest().state).moves)
    control().post({.kind = CommandKind::Abort});
}

std::optional<Result<void>> Owner::reset_answer() {
  OnBus* on_bus = parts_->on_bus.get();
  if (on_bus == nullptr || !on_bus->reset) return std::nullopt;
  if (!on_bus->reset_answer) on_bus->reset_answer = on_bus->control->answer(*on_bus->reset);
  if (!on_bus->reset_answer) return std::nullopt;
  on_bus->reset.reset();
  auto answer = *std::exchange(on_bus->reset_answer, std::nullopt);
  if (answer) return answer;
  const Error& why = answer.error();
  if (why.fault == Fault::Refused) return tl::unexpected(parts_->refusal(OrderKind::Reset));
  return fail(
      Fault::Latched,
      fmt::format("{} stays latched: {}; {}", std::string_view(code(why.fault)), why.message, info(why.fault).remedy),
      why.where);
}

void Owner::abort(Error why) {
  Parts& p = *parts_;
  if (!p.on_bus) return;
  // Of a program that ordered it and was ended; whoever ends the owner has said so already.
  const bool ends_it = p.undertaking != Undertaking::None && !p.ending && !p.control().aborting();
  if (why.fault == Fault::Interrupted && ends_it) p.acted("interrupt");
  p.abort(std::move(why));
}

void Owner::interrupt(Error why) {
  if (why.fault == Fault::Interrupted && !parts_->ending) {
    parts_->ending = why;
    parts_->acted("interrupt");
  }
  abort(std::move(why));
}

std::optional<double> Owner::stop_mm() const {
  const Parts& p = *parts_;
  if (!p.on_bus) return std::nullopt;
  const cycle::Snapshot& s = latest();
  return job::StopAhead(job::limits_of(p.machine))
      .from(p.control().plays(), {s.along_block_mm, s.path_speed, p.control().path_acceleration()});
}

std::string Owner::order_said() const { return parts_->order_said; }

const std::string& Owner::bus() const { return parts_->options.bus; }

Standing Owner::standing() const { return parts_->standing(); }

cycle::State Owner::state() const { return parts_->on_bus ? standing().state : latest().state; }

std::optional<Error> Owner::stopped() const {
  if (!parts_->on_bus || !parts_->control().stopped()) return std::nullopt;
  return parts_->control().fault();
}

bool Owner::held_by_button() const { return parts_->button_holds && held(); }

bool Owner::held() const { return standing().held; }

}  // namespace gantry::run
