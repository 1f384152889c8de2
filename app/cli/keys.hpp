// The operator's keys and the progress line while a job runs, both only on a terminal; and Ctrl-C, everywhere.
//   OwnerOperated machine(owner);   Keys keys(machine, true);   owner.on_step([&] { keys.poll(); });
// space hold / resume, a abort, + - override, r reset.
#pragma once
#include <cstdint>
#include <termios.h>

#include "app/cli/operated.hpp"

namespace gantry::cli {

class Keys {
 public:
  Keys(Operated& machine, bool progress);
  ~Keys() { end(); }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  void poll();
  /// Gives the terminal back and clears the progress line.
  void end();

 private:
  void press(char key);
  void show_progress();

  Operated& machine_;
  bool keys_ = false, progress_ = false, interrupted_ = false, shown_ = false;
  termios saved_{};
  double override_ = 1;
  std::int64_t last_shown_ = 0;
};

}  // namespace gantry::cli
