// A CPU for the loop: whatever else this program does (page faults, files, images) keeps off it, so that no work of the
// kernel on behalf of another thread of ours stands in the loop's way.
//   auto cpu = LoopCpu::take({});           // before other threads and child processes are started
//   LoopThread thread(loop, clock, channels, first, (*cpu)->number());
#pragma once
#include <memory>
#include <optional>
#include <sched.h>

#include "core/error.hpp"

namespace gantry::cycle {

class LoopCpu {
 public:
  static constexpr int kAny = -1;

  /// Takes `wanted`, or the last CPU that this process may use, and leaves the others to the calling thread and to all
  /// that it starts from now on. Where there is only one, everybody shares it. Fault::Usage when `wanted` may not be
  /// used.
  static Result<std::unique_ptr<LoopCpu>> take(std::optional<int> wanted);
  /// Whether it could be taken; takes nothing.
  static Result<void> check(std::optional<int> wanted);
  /// Gives the calling thread back what it had; to be called in the thread that took it.
  ~LoopCpu();
  LoopCpu(const LoopCpu&) = delete;
  LoopCpu& operator=(const LoopCpu&) = delete;

  [[nodiscard]] int number() const { return number_; }  ///< kAny: none to spare

 private:
  LoopCpu(int number, const cpu_set_t& before) : number_(number), before_(before) {}

  int number_;
  cpu_set_t before_;
};

}  // namespace gantry::cycle
