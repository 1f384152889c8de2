#include "app/cli/front.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

namespace gantry::cli {
namespace {

constexpr std::array kPassed{SIGINT, SIGTERM, SIGQUIT, SIGHUP, SIGTSTP, SIGCONT};

volatile pid_t behind = 0;  // of the front: its child
pid_t front = 0;            // of the child: its front

void pass_on(int number) {
  const int before = errno;
  kill(behind, number);
  errno = before;
}

[[noreturn]] void wait_in_front(const termios& terminal) {
  int status = 0;
  while (waitpid(behind, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) _exit(WEXITSTATUS(status));
  tcsetattr(STDIN_FILENO, TCSANOW, &terminal);  // who was killed did not give it back
  _exit(128 + WTERMSIG(status));
}

}  // namespace

void stand_behind_a_front() {
  termios terminal{};
  if (isatty(STDIN_FILENO) == 0 || tcgetattr(STDIN_FILENO, &terminal) != 0) return;
  sigset_t passed, before;
  sigemptyset(&passed);
  for (const int number : kPassed) sigaddset(&passed, number);
  sigprocmask(SIG_BLOCK, &passed, &before);  // none is lost before there is somebody to pass it on to
  const pid_t self = getpid(), child = fork();
  if (child == 0) {
    front = self;
    prctl(PR_SET_PDEATHSIG, SIGHUP);
    if (getppid() != self) raise(SIGHUP);
  } else if (child > 0) {
    behind = child;
    struct sigaction action {};
    action.sa_handler = pass_on;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    for (const int number : kPassed) sigaction(number, &action, nullptr);
    sigprocmask(SIG_SETMASK, &before, nullptr);
    wait_in_front(terminal);
  }
  sigprocmask(SIG_SETMASK, &before, nullptr);  // no second process: this one goes on alone
}

bool has_front() { return front != 0; }

void stop_front() {
  if (front != 0 && getppid() == front) kill(front, SIGSTOP);
}

}  // namespace gantry::cli
