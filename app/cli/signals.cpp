#include "app/cli/signals.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <ctime>
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "app/cli/terminal.hpp"
#include "app/cycle/crash_stop.hpp"

namespace gantry::cli {
namespace {

constexpr std::int64_t kSameWish_ns = 200'000'000;

// Lock-free, so that a handler may use them.
std::atomic<bool> asked{false}, lost{false}, hold_wished{false}, continued{false};
std::atomic<std::int64_t> asked_ns{0};
std::atomic<std::int64_t> looked_ns{-1};  // when it was last seen whether anybody reads the log; -1: that is not asked
constexpr std::int64_t kLookAgain_ns = 50'000'000;

std::int64_t now_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

void on_request(int number) {
  const std::int64_t now = now_ns(), before = asked_ns.exchange(now);
  if (!asked.exchange(true) || now - before < kSameWish_ns) return;
  cycle::stop_before_exit();
  _exit(128 + number);
}

void on_loss(int /*number*/) { lost = true; }
void on_stop_key(int /*number*/) { hold_wished = true; }
void on_continue(int /*number*/) { continued = true; }

void handle(int number, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

bool ignored(int number) {
  struct sigaction action {};
  return sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// A log is written now and then: that its reader is gone shows in the pipe before the next line is.
void look_for_reader() noexcept {
  const std::int64_t looked = looked_ns, now = now_ns();
  if (looked < 0 || now - looked < kLookAgain_ns) return;
  looked_ns = now;
  std::array<pollfd, 2> files{pollfd{STDOUT_FILENO, 0, 0}, pollfd{STDERR_FILENO, 0, 0}};
  if (poll(files.data(), files.size(), 0) <= 0) return;
  for (const pollfd& file : files)
    if ((file.revents & POLLERR) != 0) lost = true;
}

bool has_controlling_terminal() {
  const int fd = open("/dev/tty", O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (fd >= 0) close(fd);
  return fd >= 0;
}

}  // namespace

void catch_signals() {
  for (const int number : {SIGINT, SIGTERM, SIGQUIT}) handle(number, on_request);
  if (!ignored(SIGHUP)) handle(SIGHUP, on_loss);
  handle(SIGPIPE, SIG_IGN);
  handle(SIGXFSZ, SIG_IGN);  // of a limit that a shell has set: a file that grows no more is told where it is written
}

void hold_machine(Terminal terminal) {
  if (terminal == Terminal::Matters || has_controlling_terminal())
    handle(SIGPIPE, on_loss), looked_ns = now_ns();
  else
    handle(SIGHUP, SIG_IGN);
  for (const int number : {SIGTTIN, SIGTTOU}) handle(number, SIG_IGN);
  keep_stderr_from_waiting();
}

void hold_on_stop_key() {
  handle(SIGTSTP, on_stop_key);
  handle(SIGCONT, on_continue);
}

void stop_for_shell() {
  struct sigaction default_action {
  }, ours{};
  default_action.sa_handler = SIG_DFL;
  sigemptyset(&default_action.sa_mask);
  sigaction(SIGTSTP, &default_action, &ours);
  raise(SIGTSTP);  // not SIGSTOP: the kernel drops it where no shell waits for this process (POSIX, orphaned groups)
  sigaction(SIGTSTP, &ours, nullptr);
  continued = true;
}

bool interrupted() {
  look_for_reader();
  return asked || lost;
}
bool terminal_lost() { return lost && !asked; }
void lose_terminal() { lost = true; }
bool take_hold_wish() { return hold_wished.exchange(false); }
bool take_continued() { return continued.exchange(false); }

}  // namespace gantry::cli
