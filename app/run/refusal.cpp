#include "app/run/refusal.hpp"

#include <fmt/format.h>

namespace gantry::run {
namespace {

using cycle::State;

/// What the machine is doing, as far as a refusal differs by it.
enum class Doing {
  ComesUp,     ///< the bus is not up
  Changes,     ///< nothing is under way, and the state changes by itself
  Latched,     ///< nothing is under way, and a fault is latched
  Idle,        ///< nothing is under way
  Aborted,     ///< an abort ends it
  Faulted,     ///< a fault ends it
  Stopped,     ///< a fault has stopped the job, which waits
  Braking,     ///< the same, and the axes do not stand yet
  Halting,     ///< on the way to its hold
  Held,        ///< on hold
  Unheld,      ///< it may not be held: homing, enabling
  Motionless,  ///< it moves no axis, and is short
  Begins,      ///< it moves axes, and has not begun to
  Moves,
};

Doing doing(const Standing& now) {
  const bool moves = cycle::row(now.state).moves;
  if (!now.on_bus || now.undertaking == Undertaking::BringUp) return Doing::ComesUp;
  if (now.undertaking == Undertaking::None) {
    if (now.state == State::Stopped) return Doing::Latched;
    return now.state == State::Ready || now.state == State::Disabled ? Doing::Idle : Doing::Changes;
  }
  if (now.aborting) return Doing::Aborted;
  if (now.stopped) return now.state == State::Stopping ? Doing::Braking : Doing::Stopped;
  if (now.state == State::Stopping || now.state == State::Stopped) return Doing::Faulted;
  if (now.held || now.state == State::Held || now.state == State::Holding)
    return now.state == State::Holding ? Doing::Halting : Doing::Held;
  switch (now.undertaking) {
    case Undertaking::Enable:
    case Undertaking::Home: return Doing::Unheld;
    case Undertaking::Disable:
    case Undertaking::Part: return Doing::Motionless;
    default: return moves ? Doing::Moves : Doing::Begins;
  }
}

std::string machine_words(const Standing& now) {
  if (now.undertaking == Undertaking::None) return fmt::format("the machine is {}", cycle::name(now.state));
  return fmt::format("the machine is busy with {} ({})", in_quotes(now.undertaking), cycle::name(now.state));
}

constexpr const char* kWait = "wait until `status` shows another state";

/// For an order that takes machine time.
std::string for_another(Doing what) {
  switch (what) {
    case Doing::ComesUp: return ", and its bus comes up yet; " + std::string(kWait);
    case Doing::Changes: return ", which changes by itself; " + std::string(kWait);
    case Doing::Latched: return "; `status` names its fault, and `reset` clears it when its cause is gone";
    case Doing::Idle: return ", which has changed meanwhile; give the order again";
    case Doing::Aborted: return ", which an abort ends; give the order again when the axes stand";
    case Doing::Faulted: return ", which a fault ends; give the order again when the axes stand and `reset` is taken";
    case Doing::Stopped:
      return ", which a fault has stopped; `status` names it: `reset`, then `resume` goes on, `abort` ends it";
    case Doing::Braking: return ", which a fault stops; give the order again when the axes stand";
    case Doing::Halting:
    case Doing::Held: return ", which is on hold; `resume` goes on, `abort` ends it";
    case Doing::Unheld:
    case Doing::Motionless:
    case Doing::Begins:
    case Doing::Moves: break;
  }
  return "; wait for its end, or `abort` it";
}

std::string for_hold(Doing what) {
  switch (what) {
    case Doing::ComesUp: return ", and no axis moves before its bus is up; nothing has to be done";
    case Doing::Changes: return ", which is no motion that could be held; `abort` ends what moves";
    case Doing::Latched:
    case Doing::Idle: return ", and nothing is under way that could be held; nothing has to be done";
    case Doing::Aborted: return ", which an abort ends; the axes come to rest by themselves";
    case Doing::Faulted: return ", which a fault ends; the axes come to rest by themselves";
    case Doing::Stopped:
    case Doing::Braking:
    case Doing::Halting:
    case Doing::Held: return ", which is on hold already; nothing has to be done";
    case Doing::Unheld: return ", which cannot be held; `abort` ends it";
    case Doing::Motionless: return ", which moves no axis; wait for its end";
    case Doing::Begins: return ", which has not begun to move; `abort` ends it";
    case Doing::Moves: break;
  }
  return ", which cannot be held; `abort` ends it";
}

std::string for_resume(Doing what) {
  switch (what) {
    case Doing::ComesUp: return ", and its bus comes up yet; nothing is on hold, and nothing has to be done";
    case Doing::Latched:
      return ", and no job waits; `status` names its fault, and `reset` clears it when its cause is gone";
    case Doing::Changes:
    case Doing::Idle: return ", and nothing is on hold; nothing has to be done";
    case Doing::Aborted: return ", which an abort ends, and that is not undone; wait for its end";
    case Doing::Faulted: return ", which a fault ends, and that is not undone; wait for its end";
    case Doing::Stopped: return ", which a fault has stopped; `status` names it: `reset`, then `resume` goes on";
    case Doing::Braking: return ", which a fault stops; give the order again when the axes stand";
    case Doing::Halting: return ", which comes to rest for its hold; give the order again when it is held";
    case Doing::Held: return ", which cannot go on yet; give the order again, or `abort` ends it";
    case Doing::Unheld:
    case Doing::Motionless:
    case Doing::Begins:
    case Doing::Moves: break;
  }
  return ", which is not on hold; nothing has to be done";
}

std::string for_reset(Doing what) {
  switch (what) {
    case Doing::ComesUp: return ", and its bus comes up yet; " + std::string(kWait);
    case Doing::Changes: return ", which changes by itself; give the order again when `status` shows another state";
    case Doing::Latched:
    case Doing::Idle: return ", which has changed meanwhile; give the order again";
    case Doing::Aborted: return ", which an abort ends; give the order again when the axes stand";
    case Doing::Faulted: return ", which a fault ends; give the order again when the axes stand";
    case Doing::Stopped:
    case Doing::Braking:
    case Doing::Halting: return ", which comes to rest yet; give the order again when the axes stand";
    case Doing::Held: return ", which is on hold; `resume` goes on, `abort` ends it";
    case Doing::Unheld:
    case Doing::Motionless:
    case Doing::Begins:
    case Doing::Moves: break;
  }
  return ", and a reset is for a machine that stands; wait for its end, or `abort` it";
}

}  // namespace

std::string refusal(OrderKind order, const Standing& now) {
  const Doing what = doing(now);
  const std::string why = order == OrderKind::Hold || order == OrderKind::Override ? for_hold(what)
                          : order == OrderKind::Resume                             ? for_resume(what)
                          : order == OrderKind::Reset                              ? for_reset(what)
                                                                                   : for_another(what);
  return fmt::format("'{}' is refused: {}{}", name(order), machine_words(now), why);
}

std::string refusal(Undertaking asked, const Standing& now) {
  return fmt::format("{} is refused: {}{}", in_quotes(asked), machine_words(now), for_another(doing(now)));
}

}  // namespace gantry::run
