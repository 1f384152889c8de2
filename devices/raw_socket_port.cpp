#include "devices/raw_socket_port.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "devices/wire/ethercat.hpp"

namespace gantry::devices {
namespace {

// A deadline that is far away is waited for in naps that the kernel's coarse timers end: they cost next to nothing.
constexpr Time kNap = milliseconds(10), kNapEnds = milliseconds(30);  // ends: with room for coarse timers (HZ 100)

class Fd {
 public:
  explicit Fd(int fd) noexcept : fd_(fd) {}
  ~Fd() {
    if (fd_ >= 0) ::close(fd_);
  }
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  [[nodiscard]] int get() const noexcept { return fd_; }
  int release() noexcept { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

tl::unexpected<Error> unusable(const std::string& interface, const char* what) {
  return fail(Fault::InterfaceUnusable, fmt::format("{}: {}", what, std::strerror(errno)), "interface " + interface);
}

ifreq request_about(const std::string& interface) noexcept {
  ifreq request{};
  std::copy_n(interface.begin(), std::min(interface.size(), sizeof request.ifr_name - 1), request.ifr_name);
  return request;
}

}  // namespace

Result<std::unique_ptr<RawSocketPort>> RawSocketPort::open(const std::string& interface) {
  const unsigned index = ::if_nametoindex(interface.c_str());
  if (index == 0) return unusable(interface, "there is no such interface");
  auto lock = InterfaceLock::take(interface);
  if (!lock) return tl::unexpected(lock.error());

  const auto protocol = htons(wire::kEtherType);
  Fd fd(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, protocol));
  if (fd.get() < 0) return unusable(interface, "cannot open a raw socket (it needs CAP_NET_RAW)");
  const int on = 1;
  if (::setsockopt(fd.get(), SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on) != 0)
    return unusable(interface, "cannot leave out what is sent");
  const timeval nap{.tv_sec = 0, .tv_usec = std::chrono::duration_cast<std::chrono::microseconds>(kNap).count()};
  if (::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &nap, sizeof nap) != 0)
    return unusable(interface, "cannot bound its waits");
  // PACKET_QDISC_BYPASS stays off: what passes it by is in no capture.
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = protocol;
  address.sll_ifindex = static_cast<int>(index);
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return unusable(interface, "cannot bind to it");
  packet_mreq promiscuous{};  // stations answer with addresses that are not the card's
  promiscuous.mr_ifindex = static_cast<int>(index);
  promiscuous.mr_type = PACKET_MR_PROMISC;
  if (::setsockopt(fd.get(), SOL_PACKET, PACKET_ADD_MEMBERSHIP, &promiscuous, sizeof promiscuous) != 0)
    return unusable(interface, "cannot receive all frames");
  auto port = std::unique_ptr<RawSocketPort>(new RawSocketPort(fd.release(), std::move(*lock), interface));
  if (!port->timer_.valid()) return unusable(interface, "cannot make a timer");
  return port;
}

RawSocketPort::RawSocketPort(int socket, InterfaceLock lock, std::string interface)
    : lock_(std::move(lock)), socket_(socket), interface_(std::move(interface)) {
  ifreq request = request_about(interface_);
  if (::ioctl(socket_, SIOCGIFHWADDR, &request) != 0) return;
  constexpr std::size_t kOwn = 3;  // the bytes that the card's maker counts
  const auto* const card = reinterpret_cast<const std::byte*>(request.ifr_hwaddr.sa_data);
  std::copy_n(card + std::tuple_size_v<MacAddress> - kOwn, kOwn, source_.end() - kOwn);
}

RawSocketPort::~RawSocketPort() { ::close(socket_); }

bool RawSocketPort::send(PortIndex port, std::span<const std::byte> frame) noexcept {
  if (port != PortIndex::Primary) return false;
  return ::send(socket_, frame.data(), frame.size(), MSG_DONTWAIT) == static_cast<ssize_t>(frame.size());
}

Received RawSocketPort::receive(std::span<std::byte> buffer, Time deadline) noexcept {
  const MonotonicClock clock;
  const DeadlineTimer::Wait wait(timer_, deadline);
  for (Time now = clock.now();;) {
    const Time left = deadline - now;
    if (left > Time{} && left <= kNapEnds) timer_.aim(deadline);
    const ssize_t got = ::recv(socket_, buffer.data(), buffer.size(), left > Time{} ? 0 : MSG_DONTWAIT);
    now = clock.now();
    if (got > 0) return {static_cast<std::size_t>(got), PortIndex::Primary, now};
    if (now >= deadline) return {};
  }
}

void RawSocketPort::arm(Time deadline) noexcept { timer_.aim(deadline); }

bool RawSocketPort::link_up(PortIndex port) const noexcept {
  if (port != PortIndex::Primary) return false;
  ifreq request = request_about(interface_);
  if (::ioctl(socket_, SIOCGIFFLAGS, &request) != 0) return false;
  return (request.ifr_flags & IFF_UP) != 0 && (request.ifr_flags & IFF_RUNNING) != 0;
}

}  // namespace gantry::devices
