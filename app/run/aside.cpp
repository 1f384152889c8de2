#include "app/run/aside.hpp"

#include <chrono>
#include <utility>

namespace gantry::run {

bool Aside::run(std::function<void()> work, const std::function<bool()>& serve) {
  const auto comes_to_its_end = [&] {
    while (work_.valid() && work_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
      if (!serve()) return false;
    return true;
  };
  if (!comes_to_its_end()) return false;
  work_ = std::async(std::launch::async, std::move(work));
  if (!comes_to_its_end()) return false;
  work_.get();
  return true;
}

}  // namespace gantry::run
