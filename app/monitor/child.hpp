// The owner's side of `gantry publish`: starts it, starts it again when it dies, ends it with the owner. Nothing here
// waits for the child, and nothing that happens to the child reaches the machine.
//   PublishChild child(writer.fd());
//   child.poll(clock_now);            // now and then from the run thread, never from the loop
// The child gets the shared memory as file descriptor 3 and is told `publish --shm 3`.
#pragma once
#include <string>
#include <sys/types.h>
#include <vector>

#include "core/clock.hpp"

namespace gantry::monitor {

struct ChildOptions {
  std::string program = "/proc/self/exe";  ///< this very program, also when its file has been replaced
  std::vector<std::string> arguments{};    ///< after `publish --shm FD`: "--domain", "3", ...
  Time back_off_first = milliseconds(200);
  Time back_off_most = std::chrono::seconds(10);
};

class PublishChild {
 public:
  explicit PublishChild(int shm_fd, ChildOptions options = {});
  PublishChild(const PublishChild&) = delete;
  PublishChild& operator=(const PublishChild&) = delete;
  /// Asks the child to end, and after half a second makes it. The only place that waits.
  ~PublishChild();

  /// Starts or restarts the child when it is time. `now` of a clock that does not jump.
  void poll(Time now);
  [[nodiscard]] bool alive() const { return pid_ > 0; }
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// How often it was started.
  [[nodiscard]] int starts() const { return starts_; }

 private:
  bool reap();
  void start();

  int shm_fd_;
  ChildOptions options_;
  pid_t pid_ = -1;
  int starts_ = 0;
  Time next_start_{0}, started_{0}, back_off_;
};

}  // namespace gantry::monitor
