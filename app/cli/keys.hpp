// The operator's keys and the progress line while a job runs, both only on a terminal; and Ctrl-C, Ctrl-Z and the loss
// of the terminal, everywhere.
//   OwnerOperated machine(owner);   Keys keys(machine, Keys::Shows::ProgressAndKeys);
//   owner.on_step([&] { keys.poll(); });
// space hold / resume, n hold now, a abort, + - override, r reset.
#pragma once
#include <chrono>
#include <optional>

#include "app/cli/operated.hpp"
#include "app/cli/shell_job.hpp"
#include "app/cli/terminal.hpp"

namespace gantry::cli {

class Keys {
 public:
  enum class Shows {
    Nothing,
    Progress,        ///< of a job in virtual time: what is left is told in the time of whoever waits
    ProgressAndKeys  ///< of a job at a machine
  };
  /// `heeds_shell`: what moves is brought to a stand before the shell gets its terminal.
  Keys(Operated& machine, Shows shows, bool heeds_shell = true);
  ~Keys() { end(); }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  /// Somebody sits at a terminal whose keys can be read.
  static bool usable(bool progress);

  void poll();
  /// Gives the terminal back and clears the progress line.
  void end();

 private:
  /// Until SIGCONT: the shell is about to get its terminal.
  void sleep();
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
  bool progress_ = false, interrupted_ = false;
  bool virtual_time_ = false;  ///< the machine's seconds are not those of whoever waits
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now(), last_shown_{};
};

}  // namespace gantry::cli
