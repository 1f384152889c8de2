// What the shell and its terminal do to a verb, whether it holds the machine or is a client of an owner. Ctrl-Z: what
// moves is held or ended first; when it stands, the shell gets its terminal and the machine stays as it is. A terminal
// that is gone is noted as lost.
//   ShellJob shell(machine);   each step: shell.poll();
#pragma once
#include <functional>

#include "app/cli/operated.hpp"

namespace gantry::cli {

class ShellJob {
 public:
  explicit ShellJob(Operated& machine);

  /// `before_stop` is called when the shell is about to get its terminal.
  void poll(const std::function<void()>& before_stop = {});

 private:
  Operated& machine_;
  bool has_terminal_;
  bool wished_ = false;
};

}  // namespace gantry::cli
