// EtherCAT on a real network interface: raw Ethernet frames through AF_PACKET.
//   auto port = RawSocketPort::open("enp3s0");    // needs CAP_NET_RAW
// Owns the socket and, for as long as it lives, the interface: a second program (or port) on it is refused.
#pragma once
#include <memory>
#include <string>

#include "core/error.hpp"
#include "devices/deadline_timer.hpp"
#include "devices/frame_port.hpp"
#include "devices/interface_lock.hpp"

namespace gantry::devices {

class RawSocketPort final : public FramePort {
 public:
  /// Fault::InterfaceUnusable with the system's reason, Fault::SecondOwner when another program owns the interface.
  static Result<std::unique_ptr<RawSocketPort>> open(const std::string& interface);
  ~RawSocketPort() override;
  RawSocketPort(const RawSocketPort&) = delete;
  RawSocketPort& operator=(const RawSocketPort&) = delete;

  /// One system call, never waits. Port Secondary: false.
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override;
  /// rx_time is when the frame was read, on CLOCK_MONOTONIC.
  Received receive(std::span<std::byte> buffer, Time deadline) noexcept override;
  void arm(Time deadline) noexcept override;
  /// Its last bytes are the card's, so that two computers on one line differ.
  [[nodiscard]] SourceAddress source() const noexcept override { return source_; }
  /// A system call (SIOCGIFFLAGS); asked only when a frame is missing.
  [[nodiscard]] bool link_up(PortIndex port) const noexcept override;
  [[nodiscard]] int descriptor() const noexcept override { return socket_; }

 private:
  RawSocketPort(int socket, InterfaceLock lock, std::string interface);

  InterfaceLock lock_;
  int socket_;
  DeadlineTimer timer_;
  std::string interface_;
  SourceAddress source_ = kUsualSource;
};

}  // namespace gantry::devices
