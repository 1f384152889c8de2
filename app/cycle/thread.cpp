#include "app/cycle/thread.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <sched.h>
#include <sys/mman.h>

#include "app/cycle/crash_stop.hpp"
#include "app/cycle/pacer.hpp"

namespace gantry::cycle {
namespace {

constexpr int kPriority = 80;  // below the kernel's own watchdog threads, above everything of ours but watchdog.cpp
constexpr std::size_t kStackUsed = 256 * 1024;
constexpr time_t kJoin_s = 2;

void use_stack() {
  std::array<volatile char, kStackUsed> stack;
  for (std::size_t i = 0; i < stack.size(); i += 4096) stack[i] = 0;
}

}  // namespace

bool start_thread(pthread_t& thread, const char* name, int priority, void* (*body)(void*), void* self,
                  RealTimeRights& rights) {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0)
    rights.memory = true;
  else
    rights.refused = std::string("locked memory (mlockall: ") + std::strerror(errno) + ")";

  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 1024 * 1024);
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
  const sched_param parameter{.sched_priority = priority};
  pthread_attr_setschedparam(&attributes, &parameter);
  int error = pthread_create(&thread, &attributes, body, self);
  rights.priority = error == 0;
  if (error != 0) {
    rights.refused += std::string(rights.refused.empty() ? "" : ", ") +
                      "real-time priority (SCHED_FIFO: " + std::strerror(error) + ")";
    pthread_attr_setinheritsched(&attributes, PTHREAD_INHERIT_SCHED);
    error = pthread_create(&thread, &attributes, body, self);
  }
  pthread_attr_destroy(&attributes);
  if (error == 0) pthread_setname_np(thread, name);
  return error == 0;
}

LoopThread::LoopThread(Loop& loop, Clock& clock, Channels& channels, Time first, int cpu)
    : loop_(loop), clock_(clock), channels_(channels), first_(first) {
  running_ = start_thread(thread_, "gantry-loop", kPriority, &LoopThread::run, this, rights_);
  if (!running_ || cpu == LoopCpu::kAny) return;
  cpu_set_t alone;
  CPU_ZERO(&alone);
  CPU_SET(cpu, &alone);
  pthread_setaffinity_np(thread_, sizeof alone, &alone);
}

bool LoopThread::join() {
  if (!running_) return true;
  channels_.quit.store(true, std::memory_order_release);
  timespec until{};
  clock_gettime(CLOCK_MONOTONIC, &until);
  until.tv_sec += kJoin_s;
  running_ = pthread_clockjoin_np(thread_, nullptr, CLOCK_MONOTONIC, &until) != 0;
  return !running_;
}

void* LoopThread::run(void* self) {
  auto& me = *static_cast<LoopThread*>(self);
  const AlternateStack stack;
  use_stack();
  // Locking the memory of a large machine takes longer than a cycle; the first cycle that is still to come begins.
  const Time period = me.loop_.period(), late = me.clock_.now() - me.first_;
  Pacer pacer(late < Time{} ? me.first_ : me.first_ + (late / period + 1) * period, period);
  while (!me.channels_.quit.load(std::memory_order_acquire)) pacer.shift(me.loop_.tick(pacer.wait(me.clock_)));
  return nullptr;
}

}  // namespace gantry::cycle
