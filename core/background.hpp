// Work that may be late, on a thread of its own: where processors are short it comes behind the threads that serve the
// machine and its people.
//   std::future<Plan> plan = in_background([&] { return make_plan(); });
#pragma once
#include <future>
#include <utility>

namespace gantry {

/// Makes the calling thread nicer by 10, for as long as it lives; Linux keeps that by thread.
void come_behind_others();

/// As std::async on a new thread does it.
template <class Work>
[[nodiscard]] auto in_background(Work work) {
  return std::async(std::launch::async, [work = std::move(work)]() mutable {
    come_behind_others();
    return work();
  });
}

}  // namespace gantry
