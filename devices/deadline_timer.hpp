// Ends a blocking system call of this thread at an instant: a signal to the thread interrupts it.
//   DeadlineTimer timer;
//   const DeadlineTimer::Wait wait(timer, deadline);
//   if (clock.now() < deadline) { timer.aim(deadline);  n = ::recv(...); }   // < 0 and EINTR: it rang
// A frame is then waited for in one system call, as without a deadline; poll() on the socket and a timer beside it, and
// recv() after it, take 1 to 3 us more. Programming the timer costs 1 to 8 us (in a virtual machine a trap to the
// host), so a cycle does it when its work is done, for the next one.
// The signal is SIGURG, whose default is to be ignored. System calls that can be restarted are; a socket's receive with
// SO_RCVTIMEO is not (signal(7)), so the socket needs one. Waiting for the same timer belongs to one thread at a time.
#pragma once
#include <cstdint>
#include <ctime>
#include <optional>

#include "core/clock.hpp"

namespace gantry::devices {

class DeadlineTimer {
 public:
  /// Takes SIGURG for the process.
  DeadlineTimer() noexcept;
  ~DeadlineTimer();
  DeadlineTimer(const DeadlineTimer&) = delete;
  DeadlineTimer& operator=(const DeadlineTimer&) = delete;

  /// False: the system has no timer left (errno).
  [[nodiscard]] bool valid() const noexcept { return timer_.has_value(); }

  /// Rings in this thread at `deadline` on CLOCK_MONOTONIC. Free when that is where it aims already, else one system
  /// call, or three when another thread aimed it last.
  void aim(Time deadline) noexcept;

  /// While it lives, what has rung rings on, until it has ended a call. Only what rang before does not: whoever has
  /// made it looks at the clock before he begins to wait.
  class Wait {
   public:
    Wait(DeadlineTimer& timer, Time deadline) noexcept;
    ~Wait();
    Wait(const Wait&) = delete;
    Wait& operator=(const Wait&) = delete;
  };

 private:
  void belong_to_this_thread() noexcept;

  std::optional<timer_t> timer_;
  std::uint64_t thread_ = 0;  ///< in which it rings
  Time aimed_{};
};

}  // namespace gantry::devices
