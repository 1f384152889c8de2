// Blocking work on several stations at once: where the one waits for its mailbox, the others go on, and what they ask
// in the same moment travels in one frame.
//   SideBySide all(link);
//   for (auto& s : stations) all.add([&] { ... sdo_upload(link, s, ...) ... });
//   all.run();                                     // returns when the last has ended
// The order is that of adding, in one thread: a run is a pure function of what the stations answer. Off the RT side.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "devices/ethercat/fiber.hpp"
#include "devices/ethercat/link.hpp"

namespace gantry::devices {

class SideBySide {
 public:
  explicit SideBySide(Link& link) : link_(link) {}
  void add(std::function<void()> work);
  void run();

  // --- For Link, from inside the work ---
  [[nodiscard]] bool exchange(std::span<Datagram> of_one_frame, int attempts);
  void pause_until(Time until);

 private:
  struct Worker {
    std::unique_ptr<Fiber> fiber;
    std::span<Datagram> asked{};  ///< empty: it does not wait for an answer
    std::vector<std::vector<std::byte>> as_sent{};
    int attempts = 0;
    bool answered = false;
    Time until{};  ///< when it goes on, where it waits for nothing else
  };
  void go_on();
  void send_some();

  Link& link_;
  std::vector<Worker> workers_;
  Worker* inside_ = nullptr;
  std::size_t next_ = 0;  ///< whose turn it is to be first in a frame
};

}  // namespace gantry::devices
