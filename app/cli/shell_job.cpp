#include "app/cli/shell_job.hpp"

#include <unistd.h>

#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"

namespace gantry::cli {

ShellJob::ShellJob(Operated& machine) : machine_(machine), has_terminal_(isatty(STDIN_FILENO) != 0) {}

void ShellJob::poll(const std::function<void()>& before_stop) {
  if (has_terminal_ && stdin_is_gone()) lose_terminal();
  if (take_hold_wish()) wished_ = true;
  if (!wished_) return;
  const Operated::Stands stands = machine_.come_to_stand();
  wished_ = stands == Operated::Stands::NotYet;
  if (stands != Operated::Stands::Yes) return;
  if (before_stop) before_stop();
  machine_.suspend();
}

}  // namespace gantry::cli
