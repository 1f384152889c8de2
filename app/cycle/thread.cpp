#include "app/cycle/thread.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <sched.h>
#include <sys/mman.h>

#include "app/cycle/pacer.hpp"

namespace gantry::cycle {
namespace {

constexpr int kPriority = 80;  // below the kernel's own watchdog threads, above everything of ours
constexpr std::size_t kStackTouched = 256 * 1024;

void touch_stack() {
  std::array<volatile char, kStackTouched> stack;
  for (std::size_t i = 0; i < stack.size(); i += 4096) stack[i] = 0;
}

}  // namespace

LoopThread::LoopThread(Loop& loop, Clock& clock, Channels& channels, Time first)
    : loop_(loop), clock_(clock), channels_(channels), first_(first) {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0)
    rights_.memory = true;
  else
    rights_.refused = std::string("locked memory (mlockall: ") + std::strerror(errno) + ")";

  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 1024 * 1024);
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
  const sched_param parameter{.sched_priority = kPriority};
  pthread_attr_setschedparam(&attributes, &parameter);
  int error = pthread_create(&thread_, &attributes, &LoopThread::run, this);
  rights_.priority = error == 0;
  if (error != 0) {
    rights_.refused += std::string(rights_.refused.empty() ? "" : ", ") +
                       "real-time priority (SCHED_FIFO: " + std::strerror(error) + ")";
    pthread_attr_setinheritsched(&attributes, PTHREAD_INHERIT_SCHED);
    error = pthread_create(&thread_, &attributes, &LoopThread::run, this);
  }
  pthread_attr_destroy(&attributes);
  running_ = error == 0;
}

void LoopThread::join() {
  if (!running_) return;
  channels_.quit.store(true, std::memory_order_release);
  pthread_join(thread_, nullptr);
  running_ = false;
}

void* LoopThread::run(void* self) {
  auto& me = *static_cast<LoopThread*>(self);
  touch_stack();
  Pacer pacer(me.first_, me.loop_.period());
  while (!me.channels_.quit.load(std::memory_order_acquire)) pacer.shift(me.loop_.tick(pacer.wait(me.clock_)));
  return nullptr;
}

}  // namespace gantry::cycle
