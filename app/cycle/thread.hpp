// Gives the loop its thread in a real run: SCHED_FIFO, locked and touched memory, and an honest word about what the
// system refused.
//   LoopThread thread(loop, clock, channels, first_cycle);   ...   thread.join();   thread.rights().priority
#pragma once
#include <pthread.h>
#include <string>

#include "app/cycle/channels.hpp"
#include "app/cycle/loop.hpp"
#include "core/clock.hpp"

namespace gantry::cycle {

/// What the system granted.
struct RealTimeRights {
  bool priority = false;  ///< SCHED_FIFO
  bool memory = false;    ///< mlockall
  std::string refused;    ///< what was refused and why, "" when all was granted
};

class LoopThread {
 public:
  /// Starts at once; cycles begin at `first`. `loop`, `clock` and `channels` must live until join().
  LoopThread(Loop& loop, Clock& clock, Channels& channels, Time first);
  ~LoopThread() { join(); }
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  /// Asks the loop to end after its running cycle and waits for it.
  void join();
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
