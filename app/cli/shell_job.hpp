// What the shell and its terminal do to a verb that holds the machine. Ctrl-Z: what moves is held or ended first; when
// it stands, the shell gets its terminal and the machine stays as it is. A terminal that is gone is noted as lost.
//   ShellJob shell(owner, ShellJob::Of::Job);   // each step: shell.poll();
#pragma once
#include <functional>

#include "app/run/owner.hpp"

namespace gantry::cli {

class ShellJob {
 public:
  enum class Of {
    Job,     ///< one job or homing of this verb: nothing else is waited for
    Service  ///< an owner that stands idle most of the time
  };
  ShellJob(run::Owner& owner, Of of);

  /// `before_stop` is called when the shell is about to get its terminal.
  void poll(const std::function<void()>& before_stop = {});

 private:
  bool stands();
  void end_it(const char* why);

  run::Owner& owner_;
  Of of_;
  bool has_terminal_;
  bool wished_ = false;
};

}  // namespace gantry::cli
