// Sees that the loop is stuck or gone, and speaks for it: when its beat has been missing for too long, the stop frame
// goes out. The stations' own watchdogs would answer too, but later, and with the old motion until then.
//   Watchdog dog(stop, clock, setup.stuck_after());     // until it is destroyed
// A thread of its own above the loop's. On a bus of hardware only: a virtual segment in this process stands still with
// its loop, and virtual time has nothing to watch.
#pragma once
#include <atomic>
#include <cstdint>
#include <pthread.h>

#include "app/cycle/stop_frame.hpp"
#include "app/cycle/thread.hpp"
#include "core/clock.hpp"

namespace gantry::cycle {

/// One send() of bytes that stand ready (for each frame that the map needs), from any thread or signal handler; the
/// loop finds out by StopFrame::sent(). False: there is no frame yet, or the system did not take it.
bool send(StopFrame& stop) noexcept;

/// Of SCHED_FIFO: above the loop, which may be what does not let go of the processor. The highest that is asked for.
inline constexpr int kWatchdogPriority = 85;

class Watchdog {
 public:
  /// Watches from the loop's first beat on. `stop` and `clock` must live as long as this. A loop that has been spoken
  /// for is left in peace until it beats again.
  Watchdog(StopFrame& stop, Clock& clock, Time stuck_after);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// How often it had to speak.
  [[nodiscard]] std::uint32_t strikes() const noexcept { return strikes_.load(); }
  [[nodiscard]] const RealTimeRights& rights() const { return rights_; }

 private:
  static void* run(void* self);
  void watch() noexcept;

  StopFrame& stop_;
  Clock& clock_;
  Time stuck_after_;
  std::atomic<bool> quit_{false};
  std::atomic<std::uint32_t> strikes_{0};
  RealTimeRights rights_;
  pthread_t thread_{};
  bool running_ = false;
};

}  // namespace gantry::cycle
