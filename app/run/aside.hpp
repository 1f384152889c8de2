// Work that may wait for others, the world or a disk: on a thread of its own, while the machine is served.
//   Aside aside;   aside.run([&] { folder = make_folder(); }, [&] { owner.idle(); return true; });
// What the work uses is its own until it is done: no step may touch it, and work that is left behind owns all of it.
#pragma once
#include <functional>
#include <future>

namespace gantry::run {

class Aside {
 public:
  /// `serve` is called in this thread, again and again, until the work is done: true then. It lets about a cycle pass;
  /// as soon as it gives false, nobody waits any more: false then, and the work goes on unheard. Work that was left
  /// behind comes to its end before the next one begins.
  bool run(std::function<void()> work, const std::function<bool()>& serve);

 private:
  std::future<void> work_;
};

}  // namespace gantry::run
