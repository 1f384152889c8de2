// Ends a wait for frames at an instant. Programming it costs 1 to 8 us (in a virtual machine a trap to the host), so a
// cycle does it when its work is done, for the next one: no wait for a frame programs a timer then.
//   DeadlineTimer timer;   timer.aim(deadline);   ...   poll(frames, timer.descriptor())
// It is never read: reading a timer that ticks by itself programs it again.
#pragma once
#include "core/clock.hpp"

namespace gantry::devices {

class DeadlineTimer {
 public:
  DeadlineTimer() noexcept;
  ~DeadlineTimer();
  DeadlineTimer(const DeadlineTimer&) = delete;
  DeadlineTimer& operator=(const DeadlineTimer&) = delete;

  /// False: the system has no timer left (errno).
  [[nodiscard]] bool valid() const noexcept { return fd_ >= 0; }
  /// Readable from the deadline on.
  [[nodiscard]] int descriptor() const noexcept { return fd_; }

  /// Ends at `deadline` on CLOCK_MONOTONIC. Free when that is where it aims already, else one system call.
  void aim(Time deadline) noexcept;

 private:
  int fd_;
  Time aimed_{};
};

}  // namespace gantry::devices
