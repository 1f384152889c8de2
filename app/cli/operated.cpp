#include "app/cli/operated.hpp"

#include "app/cli/front.hpp"
#include "core/log.hpp"

namespace gantry::cli {

using cycle::State;

JobSeen OwnerOperated::seen() const {
  const cycle::Snapshot& s = owner_.latest();
  return {.state = std::string(cycle::name(owner_.state())),
          .held = owner_.held(),
          .cycle = s.cycle,
          .override_factor = s.override_factor,
          .progress = owner_.progress()};
}

void OwnerOperated::interrupt() {
  owner_.interrupt(Error{Fault::Interrupted, "interrupted; the machine has come to rest and the valve is closed", ""});
}

/// A service goes on afterwards; a verb for one job has nothing else to do.
Operated::Stands OwnerOperated::end_it(const char* why) {
  owner_.interrupt(Error{of_ == Of::Job ? Fault::Interrupted : Fault::Aborted, why, ""});
  return Stands::Ended;
}

Operated::Stands OwnerOperated::come_to_stand() {
  if (of_ == Of::Job && !has_front()) return end_it("Ctrl-Z: without a terminal's keys nobody could resume it");
  const State state = owner_.latest().state;
  if (owner_.held()) return cycle::row(state).moves ? Stands::NotYet : Stands::Yes;
  if (state == State::Enabling || state == State::Homing) return end_it("Ctrl-Z: homing cannot be held, and was ended");
  if (of_ == Of::Service && owner_.undertaking() == run::Undertaking::None) return Stands::Yes;
  // Refused while nothing can be held yet, and where an abort ends it anyway: then the next cycle asks again.
  static_cast<void>(owner_.order({.kind = run::OrderKind::Hold, .now = true}));
  return Stands::NotYet;
}

void OwnerOperated::suspend() {
  if (owner_.held()) log::info("held; the machine keeps its owner while the shell has the terminal");
  stop_front();
}

}  // namespace gantry::cli
