#include "app/cli/terminal.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/error.hpp"
#include "core/status_line.hpp"

namespace gantry::cli {

namespace {
int refused_by_stdout = 0;  // errno of the first write that failed
}

void say_text(std::string_view raw) noexcept try {
  const std::string clean = clean_lines(raw);
  std::string_view text = clean;
  clear_status();
  while (!text.empty()) {
    const ssize_t n = write(STDERR_FILENO, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
} catch (...) {  // no memory for the words
}

void print_raw(std::string_view text) noexcept {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() && refused_by_stdout == 0)
    refused_by_stdout = errno;
}

int close_output(int exit_code) {
  errno = 0;
  if (std::fflush(stdout) != 0 && refused_by_stdout == 0) refused_by_stdout = errno;
  pollfd reader{STDOUT_FILENO, 0, 0};
  const bool gone = poll(&reader, 1, 0) > 0 && (reader.revents & (POLLERR | POLLHUP)) != 0;
  if (std::ferror(stdout) == 0 || gone) return exit_code;
  // A stream of the library that was refused leaves no errno.
  const Error error{Fault::FileUnwritable,
                    fmt::format("what was to be printed has not arrived ({})",
                                refused_by_stdout != 0 ? std::strerror(refused_by_stdout) : "it was not taken"),
                    "stdout"};
  const FaultInfo& f = info(error.fault);
  say("{}\n    remedy: {}\n", to_text(error), f.remedy);
  return exit_code != 0 ? exit_code : static_cast<int>(f.exit_code);
}

void keep_stderr_from_waiting() {
  struct stat what {};
  if (fstat(STDERR_FILENO, &what) != 0 || !(S_ISCHR(what.st_mode) || S_ISFIFO(what.st_mode))) return;
  // Opened anew: the flag belongs to what was opened, which the shell and our stdin share.
  const int own = open("/proc/self/fd/2", O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (own < 0) return;  // another user's terminal (`su`): its words may then wait
  dup2(own, STDERR_FILENO);
  close(own);
}

bool in_front(int fd) {
  const pid_t there = tcgetpgrp(fd);
  return there < 0 || there == getpgrp();  // a terminal that controls nobody has no background
}

bool stdin_is_gone() {
  pollfd p{STDIN_FILENO, POLLIN, 0};
  return poll(&p, 1, 0) > 0 && (p.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

std::optional<char> read_key() {
  pollfd p{STDIN_FILENO, POLLIN, 0};
  char key = 0;
  if (poll(&p, 1, 0) <= 0 || read(STDIN_FILENO, &key, 1) != 1) return std::nullopt;
  return key;
}

bool RawTerminal::enter() {
  if (isatty(STDIN_FILENO) == 0 || !in_front(STDIN_FILENO)) return false;
  if (!raw_ && tcgetattr(STDIN_FILENO, &before_) != 0) return false;
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  raw_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
  return raw_;
}

void RawTerminal::leave() {
  if (raw_ && in_front(STDIN_FILENO)) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  raw_ = false;
}

}  // namespace gantry::cli
