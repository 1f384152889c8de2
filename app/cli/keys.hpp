// The operator's keys and the progress line while a job runs, both only on a terminal; and Ctrl-C, Ctrl-Z and the loss
// of the terminal, everywhere.
//   OwnerOperated machine(owner);   Keys keys(machine, true, &owner);   owner.on_step([&] { keys.poll(); });
// space hold / resume, n hold now, a abort, + - override, r reset.
#pragma once
#include <cstdint>
#include <optional>

#include "app/cli/operated.hpp"
#include "app/cli/shell_job.hpp"
#include "app/cli/terminal.hpp"

namespace gantry::cli {

class Keys {
 public:
  /// `held_here`: the owner, where this process holds the machine; null in a client.
  Keys(Operated& machine, bool progress, run::Owner* held_here = nullptr);
  ~Keys() { end(); }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  /// Somebody sits at a terminal whose keys can be read.
  static bool usable(bool progress);

  void poll();
  /// Gives the terminal back and clears the progress line.
  void end();
  /// The same until SIGCONT: the shell is about to get its terminal.
  void sleep();

 private:
  void read_keys();
  void press(char key);
  void show_progress();
  void clear_line();

  Operated& machine_;
  RawTerminal terminal_;
  std::optional<ShellJob> shell_;
  bool keys_ = false;    ///< stdin is a terminal whose keys are read
  bool raw_ = false;     ///< they come now; in the shell's background they do not
  bool asleep_ = false;  ///< since Ctrl-Z, until SIGCONT
  bool progress_ = false, interrupted_ = false, shown_ = false;
  std::int64_t last_shown_ = 0;
};

}  // namespace gantry::cli
