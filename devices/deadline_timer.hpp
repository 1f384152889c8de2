// Ends waits at deadlines that come once a cycle. It is programmed once and then ticks on with the cycle, whether
// somebody waits or not: a timer that is programmed for each wait, and back when the wait ends early, costs two traps
// to the host of a virtual machine, both inside the round trip of a frame.
//   DeadlineTimer timer;   timer.aim(deadline);   poll(frames, timer.descriptor()) ...
#pragma once
#include "core/clock.hpp"

namespace gantry::devices {

class DeadlineTimer {
 public:
  /// A tick comes at most this late.
  static constexpr Time kLate = microseconds(30);

  DeadlineTimer() noexcept;
  ~DeadlineTimer();
  DeadlineTimer(const DeadlineTimer&) = delete;
  DeadlineTimer& operator=(const DeadlineTimer&) = delete;

  /// False: the system has no timer left (errno).
  [[nodiscard]] bool valid() const noexcept { return fd_ >= 0; }
  /// Readable when it has ticked since clear() or aim().
  [[nodiscard]] int descriptor() const noexcept { return fd_; }

  /// A tick comes at `deadline` (CLOCK_MONOTONIC) or up to kLate after it; to a wait of more than a period others come
  /// before. One system call, which programs nothing while deadlines keep to the period that the last two had.
  void aim(Time deadline) noexcept;
  /// Takes the ticks that have been.
  void clear() noexcept;

 private:
  int fd_;
  Time last_{};    ///< deadline
  Time tick_{};    ///< one of its ticks
  Time period_{};  ///< 0: no more than that one
};

}  // namespace gantry::devices
