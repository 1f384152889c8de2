// Shows that something takes its time, and for how long it has: on a terminal as it goes, else by a line every 10 s.
//   LongWork work("checking board.yaml");   prove(..., work.breath(), work.progress());
#pragma once
#include <chrono>
#include <string>

#include "core/breath.hpp"
#include "core/progress.hpp"

namespace gantry::cli {

class LongWork {
 public:
  explicit LongWork(std::string what);
  ~LongWork();
  LongWork(const LongWork&) = delete;
  LongWork& operator=(const LongWork&) = delete;

  /// Never gives up. Not to be called when this is gone.
  Breath breath();
  /// How far it is, and by that how long it takes yet. Not to be called when this is gone.
  Progress progress();

 private:
  void show();

  using Clock = std::chrono::steady_clock;
  std::string what_;
  bool terminal_;
  std::size_t done_ = 0, total_ = 0;  ///< 0, 0: nobody says
  Clock::time_point begin_ = Clock::now(), shown_ = begin_;
};

}  // namespace gantry::cli
