#include "devices/deadline_timer.hpp"

#include <sys/timerfd.h>
#include <unistd.h>

namespace gantry::devices {
namespace {

// Cycles that a bus may have. Deadlines that are nearer to each other or farther apart are single ones.
constexpr Time kShortest = microseconds(100), kLongest = milliseconds(20);

}  // namespace

DeadlineTimer::DeadlineTimer() noexcept : fd_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)) {}

DeadlineTimer::~DeadlineTimer() {
  if (fd_ >= 0) ::close(fd_);
}

void DeadlineTimer::clear() noexcept {
  std::uint64_t ticks = 0;
  [[maybe_unused]] const auto got = ::read(fd_, &ticks, sizeof ticks);
}

void DeadlineTimer::aim(Time deadline) noexcept {
  const Time step = deadline - last_;
  last_ = deadline;
  const Time ahead = tick_ - deadline;  // of the tick that is known
  const Time late = period_ > Time{} ? (ahead % period_ + period_) % period_ : ahead;
  if (late >= Time{} && late <= kLate) return clear();
  period_ = step >= kShortest && step <= kLongest ? step : Time{};
  tick_ = deadline + kLate / 2;  // the cycle may drift either way for a while
  const itimerspec program{.it_interval = to_timespec(period_), .it_value = to_timespec(tick_)};
  ::timerfd_settime(fd_, TFD_TIMER_ABSTIME, &program, nullptr);  // forgets earlier ticks, too
}

}  // namespace gantry::devices
