#include "devices/deadline_timer.hpp"

#include <sys/timerfd.h>
#include <unistd.h>

namespace gantry::devices {

DeadlineTimer::DeadlineTimer() noexcept : fd_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)) {}

DeadlineTimer::~DeadlineTimer() {
  if (fd_ >= 0) ::close(fd_);
}

void DeadlineTimer::aim(Time deadline) noexcept {
  if (deadline == aimed_) return;
  aimed_ = deadline;
  const itimerspec program{.it_interval = {}, .it_value = to_timespec(deadline)};
  ::timerfd_settime(fd_, TFD_TIMER_ABSTIME, &program, nullptr);  // forgets an earlier end, too
}

}  // namespace gantry::devices
