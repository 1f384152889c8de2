#include "app/cycle/crash_stop.hpp"

#include <atomic>
#include <cassert>
#include <ctime>
#include <sys/mman.h>

#include "app/cycle/watchdog.hpp"

namespace gantry::cycle {
namespace {

constexpr std::size_t kStackBytes = 64 * 1024;
constexpr Time kExchangeEnds = milliseconds(2);  // an exchange waits for its answer for less than a cycle

// A signal handler has no other way to its object.
std::atomic<StopFrame*> armed{nullptr};

Time now() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::chrono::seconds(t.tv_sec) + nanoseconds(t.tv_nsec);
}

void on_crash(int number) {
  stop_before_exit();
  struct sigaction plain {};
  plain.sa_handler = SIG_DFL;
  sigaction(number, &plain, nullptr);
  raise(number);  // it is blocked here, and taken as soon as this handler returns
}

}  // namespace

void stop_before_exit() noexcept {
  StopFrame* stop = armed.load();
  if (stop == nullptr) return;
  send(*stop);
  if (!stop->exchanging()) return;
  // The loop of a process that is not quite dead may be about to send its own frame, which would enable the drives
  // again. When that exchange is over, it sends no motion any more (StopFrame::sent), and ours is the last word.
  for (const Time until = now() + kExchangeEnds; stop->exchanging() && now() < until;) {
  }
  send(*stop);
}

AlternateStack::AlternateStack() {
  void* memory = mmap(nullptr, kStackBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
  if (memory == MAP_FAILED) return;  // the handlers then run on the ordinary stack
  memory_ = memory;
  stack_t stack{};
  stack.ss_sp = memory;
  stack.ss_size = kStackBytes;
  sigaltstack(&stack, &before_);
}

AlternateStack::~AlternateStack() {
  if (memory_ == nullptr) return;
  sigaltstack(&before_, nullptr);
  munmap(memory_, kStackBytes);
}

CrashStop::CrashStop(StopFrame& stop) {
  assert(armed.load() == nullptr);
  armed.store(&stop);
  struct sigaction action {};
  action.sa_handler = on_crash;
  action.sa_flags = SA_ONSTACK;
  sigfillset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before_[i]);
}

CrashStop::~CrashStop() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  armed.store(nullptr);
}

}  // namespace gantry::cycle
