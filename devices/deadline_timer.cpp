#include "devices/deadline_timer.hpp"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <unistd.h>

namespace gantry::devices {
namespace {

constexpr int kSignal = SIGURG;
constexpr Time kAgain = microseconds(50);

/// What the handler of the signal has to know of its thread.
struct Waiting {
  timer_t timer{};
  std::atomic<Time> deadline{kNever};  ///< kNever: it waits for nothing
};
constinit thread_local Waiting waiting;

/// Threads by number, as neither an address nor an id of the system's is one thread's for ever.
std::uint64_t this_thread() noexcept {
  static constinit std::atomic<std::uint64_t> threads{0};
  static constinit thread_local std::uint64_t number = 0;
  if (number == 0) number = ++threads;
  return number;
}

void program(timer_t timer, Time at, int flags) noexcept {
  const itimerspec once{.it_interval = {}, .it_value = to_timespec(at)};
  ::timer_settime(timer, flags, &once, nullptr);
}

/// The signal alone ends the call that it interrupts. Where it came just before the call it has ended nothing yet.
void ring(int) {
  const int kept = errno;
  if (MonotonicClock().now() >= waiting.deadline.load(std::memory_order_acquire)) program(waiting.timer, kAgain, 0);
  errno = kept;
}

}  // namespace

DeadlineTimer::DeadlineTimer() noexcept {
  struct sigaction action {};
  action.sa_handler = ring;
  action.sa_flags = SA_RESTART;
  ::sigaction(kSignal, &action, nullptr);
  belong_to_this_thread();
}

DeadlineTimer::~DeadlineTimer() {
  if (timer_) ::timer_delete(*timer_);
}

void DeadlineTimer::belong_to_this_thread() noexcept {
  if (thread_ == this_thread()) return;
  if (timer_) ::timer_delete(*timer_);
  timer_.reset();
  aimed_ = Time{};
  thread_ = this_thread();
  sigevent event{};
  event.sigev_notify = SIGEV_THREAD_ID;
  event.sigev_signo = kSignal;
  event._sigev_un._tid = ::gettid();
  timer_t made{};
  if (::timer_create(CLOCK_MONOTONIC, &event, &made) == 0) timer_ = made;
}

void DeadlineTimer::aim(Time deadline) noexcept {
  belong_to_this_thread();
  if (deadline == aimed_ || !timer_) return;
  aimed_ = deadline;
  program(*timer_, deadline, TIMER_ABSTIME);
}

DeadlineTimer::Wait::Wait(DeadlineTimer& timer, Time deadline) noexcept {
  timer.belong_to_this_thread();
  if (!timer.timer_) return;
  waiting.timer = *timer.timer_;
  waiting.deadline.store(deadline, std::memory_order_release);
}

DeadlineTimer::Wait::~Wait() { waiting.deadline.store(kNever, std::memory_order_release); }

}  // namespace gantry::devices
