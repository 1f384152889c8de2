// Words to people on stderr, results on stdout, and the terminal that they come from. Nothing here fails: a terminal
// that is gone, a disk that is full, or a slow reader costs the words and not the program. Names of files, serials and
// the like in them are cleaned: nothing that someone wrote steers the terminal.
//   say("keys: {}\n", keys);              // stderr
//   print_text("{}\n", figures);          // stdout
//   return close_output(exit_code);       // at the end: whether what was printed has arrived
#pragma once
#include <fmt/format.h>
#include <optional>
#include <string_view>
#include <termios.h>
#include <utility>

#include "core/clean_text.hpp"

namespace gantry::cli {

void say_text(std::string_view text) noexcept;

template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args) {
  say_text(fmt::format(format, std::forward<Args>(args)...));
}

/// On stdout, byte by byte as it is.
void print_raw(std::string_view text) noexcept;

template <class... Args>
void print_text(fmt::format_string<Args...> format, Args&&... args) {
  print_raw(clean_lines(fmt::format(format, std::forward<Args>(args)...)));
}

/// The exit code in the end: `exit_code`, but for 0 that of G902, which it says, where stdout has not taken all that
/// was printed (a full disk). A reader that has gone (`... | head`) or a lost terminal has seen enough.
int close_output(int exit_code);

/// From now on a write to stderr never waits for its reader (Ctrl-S, a full pipe): what does not fit is dropped.
void keep_stderr_from_waiting();

/// Whether this process may talk with terminal `fd`: it does not stand in the background of the shell there.
bool in_front(int fd);

/// Nobody is at the other end of stdin any more.
bool stdin_is_gone();
/// The next byte of stdin, if one is there.
std::optional<char> read_key();

/// A terminal that gives each key as it is pressed. Ctrl-C and Ctrl-Z stay signals.
class RawTerminal {
 public:
  RawTerminal() = default;
  ~RawTerminal() { leave(); }
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;

  /// False when stdin is no terminal, or this process stands in its background.
  bool enter();
  /// As it was before enter().
  void leave();

 private:
  bool raw_ = false;
  termios before_{};
};

}  // namespace gantry::cli
