// Ctrl-C as the flag that blocking services look at.
//   StopFlag stop;   serve(..., stop.flag());
#pragma once
#include <atomic>
#include <chrono>
#include <thread>

#include "app/cli/signals.hpp"

namespace gantry::cli {

class StopFlag {
 public:
  StopFlag()
      : watch_([this](const std::stop_token& done) {
          while (!done.stop_requested() && !interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
          stop_ = true;
        }) {}
  [[nodiscard]] const std::atomic<bool>& flag() const { return stop_; }

 private:
  std::atomic<bool> stop_{false};
  std::jthread watch_;
};

}  // namespace gantry::cli
