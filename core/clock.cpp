#include "core/clock.hpp"

#include <cerrno>

namespace gantry {

Time MonotonicClock::now() const noexcept {
  timespec ts{};
  clock_gettime(CLOCK_MONOTONIC, &ts);
  return Time{static_cast<std::int64_t>(ts.tv_sec) * 1'000'000'000 + ts.tv_nsec};
}

void MonotonicClock::sleep_until(Time t) noexcept {
  if (t <= now()) return;  // the kernel would arm a timer for it and wait for its interrupt: 20 us
  const timespec ts = to_timespec(t);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &ts, nullptr) == EINTR) {
  }
}

}  // namespace gantry
