#include "app/cli/shell_job.hpp"

#include <unistd.h>

#include "app/cli/front.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "core/log.hpp"

namespace gantry::cli {

using cycle::State;

ShellJob::ShellJob(run::Owner& owner, Of of) : owner_(owner), of_(of), has_terminal_(isatty(STDIN_FILENO) != 0) {}

void ShellJob::end_it(const char* why) {
  owner_.interrupt(Error{Fault::Interrupted, why, ""});
  wished_ = false;
}

/// Whether nothing moves and nothing will before somebody resumes it; asks for that.
bool ShellJob::stands() {
  switch (owner_.latest().state) {
    case State::Running:
      if (auto held = owner_.order({.kind = run::OrderKind::Hold}); !held) log::report(held.error());
      return false;
    case State::Held: return owner_.latest().path_speed == 0;
    case State::Enabling:
    case State::Homing: end_it("Ctrl-Z: homing cannot be held, and was ended"); return false;
    default: return of_ == Of::Service && owner_.progress().features_total == 0;
  }
}

bool ShellJob::poll(const std::function<void()>& before_stop) {
  if (has_terminal_ && stdin_is_gone()) lose_terminal();
  if (take_hold_wish()) {
    wished_ = true;
    if (of_ == Of::Job && !has_front()) end_it("Ctrl-Z: without a terminal's keys nobody could resume it");
  }
  if (!wished_ || !stands()) return false;
  wished_ = false;
  if (owner_.latest().state == State::Held)
    log::info("held; the machine keeps its owner while the shell has the terminal");
  if (before_stop) before_stop();
  stop_front();
  return true;
}

}  // namespace gantry::cli
