// Gives the loop its thread in a real run: SCHED_FIFO, locked and touched memory, and an honest word about what the
// system refused.
//   LoopThread thread(loop, clock, channels, first_cycle);   ...   thread.join();   thread.rights().priority
#pragma once
#include <pthread.h>
#include <string>

#include "app/cycle/channels.hpp"
#include "app/cycle/loop.hpp"
#include "app/cycle/loop_cpu.hpp"
#include "core/clock.hpp"

namespace gantry::cycle {

/// What the system granted.
struct RealTimeRights {
  bool priority = false;  ///< SCHED_FIFO
  bool memory = false;    ///< mlockall
  std::string refused;    ///< what was refused and why, "" when all was granted
};

/// Locks the memory of the process and starts a thread with a real-time priority, as far as the system allows it;
/// `rights` says how far. `name`: at most 15 characters. False: there is no thread.
bool start_thread(pthread_t& thread, const char* name, int priority, void* (*body)(void*), void* self,
                  RealTimeRights& rights);

class LoopThread {
 public:
  /// Starts at once, on `cpu` alone (LoopCpu::kAny: anywhere); cycles begin at `first`, or whole periods after it
  /// when the thread is not ready by then. `loop`, `clock` and `channels` must live until join().
  LoopThread(Loop& loop, Clock& clock, Channels& channels, Time first, int cpu = LoopCpu::kAny);
  ~LoopThread() { join(); }
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  /// Asks the loop to end after its running cycle and waits for it, but not for ever. False: it hangs, and what it uses
  /// must stay where it is.
  bool join();
  [[nodiscard]] const RealTimeRights& rights() const { return rights_; }

 private:
  static void* run(void* self);

  Loop& loop_;
  Clock& clock_;
  Channels& channels_;
  Time first_;
  RealTimeRights rights_;
  pthread_t thread_{};
  bool running_ = false;
};

}  // namespace gantry::cycle
