// Shows on a terminal that something takes its time, and for how long it has.
//   LongWork work("checking board.yaml");   prepare(machine, file, {}, {.breath = work.breath()});
#pragma once
#include <chrono>
#include <string>

#include "core/breath.hpp"

namespace gantry::cli {

class LongWork {
 public:
  explicit LongWork(std::string what);
  ~LongWork();
  LongWork(const LongWork&) = delete;
  LongWork& operator=(const LongWork&) = delete;

  /// Never gives up. Not to be called when this is gone.
  Breath breath();

 private:
  void show();

  using Clock = std::chrono::steady_clock;
  std::string what_;
  bool shows_;
  Clock::time_point begin_ = Clock::now(), shown_ = begin_;
};

}  // namespace gantry::cli
