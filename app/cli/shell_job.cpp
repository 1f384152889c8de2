#include "app/cli/shell_job.hpp"

#include <unistd.h>

#include "app/cli/front.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "core/log.hpp"

namespace gantry::cli {

using cycle::State;

ShellJob::ShellJob(run::Owner& owner, Of of) : owner_(owner), of_(of), has_terminal_(isatty(STDIN_FILENO) != 0) {}

/// A service goes on afterwards; a verb for one job has nothing else to do.
void ShellJob::end_it(const char* why) {
  owner_.interrupt(Error{of_ == Of::Job ? Fault::Interrupted : Fault::Aborted, why, ""});
  wished_ = false;
}

/// Whether nothing moves and nothing will before somebody resumes it; asks for that.
bool ShellJob::stands() {
  const State state = owner_.latest().state;
  if (owner_.held()) return state != State::Holding;
  if (state == State::Enabling || state == State::Homing) {
    end_it("Ctrl-Z: homing cannot be held, and was ended");
    return false;
  }
  if (of_ == Of::Service && owner_.undertaking() == run::Undertaking::None) return true;
  // Refused while nothing can be held yet, and where an abort ends it anyway: then the next cycle asks again.
  static_cast<void>(owner_.order({.kind = run::OrderKind::Hold, .now = true}));
  return false;
}

void ShellJob::poll(const std::function<void()>& before_stop) {
  if (has_terminal_ && stdin_is_gone()) lose_terminal();
  if (take_hold_wish()) {
    wished_ = true;
    if (of_ == Of::Job && !has_front()) end_it("Ctrl-Z: without a terminal's keys nobody could resume it");
  }
  if (!wished_ || !stands()) return;
  wished_ = false;
  if (owner_.held()) log::info("held; the machine keeps its owner while the shell has the terminal");
  if (before_stop) before_stop();
  stop_front();
}

}  // namespace gantry::cli
