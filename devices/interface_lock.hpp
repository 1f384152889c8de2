// One controller on one network interface. The lock is the kernel's and not a file's: a packet socket in a fan-out
// group that takes one member (packet(7); `max_num_members` since Linux 5.11). Only who may send raw frames there
// (CAP_NET_RAW) can take it, it is known in every folder and to every user of the network namespace, and it ends with
// its process. docs/decisions/011 has the choice.
//   auto lock = InterfaceLock::take("enp3s0");   // by RawSocketPort, before its first frame, and kept as long as it
#pragma once
#include <string>

#include "core/error.hpp"

namespace gantry::devices {

class InterfaceLock {
 public:
  /// Fault::SecondOwner when another process holds it; InterfaceUnusable when there is no such interface or no right.
  static Result<InterfaceLock> take(const std::string& interface);
  ~InterfaceLock();
  InterfaceLock(InterfaceLock&& other) noexcept;
  InterfaceLock& operator=(InterfaceLock&&) = delete;

 private:
  explicit InterfaceLock(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace gantry::devices
