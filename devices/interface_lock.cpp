#include "devices/interface_lock.hpp"

#include <arpa/inet.h>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

#include "devices/packet_socket_owner.hpp"

namespace gantry::devices {
namespace {

// IEEE Std 802: "Local Experimental EtherType 1". Nothing of the bus is received on this socket.
constexpr std::uint16_t kNoProtocolOfTheBus = 0x88B5;

/// struct fanout_args of linux/if_packet.h, which older headers have without its last member.
struct FanoutArguments {
  std::uint16_t id;
  std::uint16_t type_flags;
  std::uint32_t most_members;
};

}  // namespace

Result<InterfaceLock> InterfaceLock::take(const std::string& interface) {
  const auto unusable = [&](const char* what, int why) {
    return fail(Fault::InterfaceUnusable, fmt::format("{}: {}", what, std::strerror(why)), interface);
  };
  const unsigned index = if_nametoindex(interface.c_str());
  if (index == 0) return unusable("there is no such interface", errno);
  const int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
  if (fd < 0) return unusable("no raw socket can be made", errno);
  InterfaceLock lock(fd);
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(kNoProtocolOfTheBus);
  address.sll_ifindex = static_cast<int>(index);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
    return unusable("it cannot be locked", errno);
  const FanoutArguments alone{static_cast<std::uint16_t>(index), PACKET_FANOUT_HASH, 1};
  if (setsockopt(fd, SOL_PACKET, PACKET_FANOUT, &alone, sizeof(alone)) == 0) return lock;
  if (errno == ENOSPC) {
    const std::string owner = packet_socket_owner(index, kNoProtocolOfTheBus);
    return fail(Fault::SecondOwner,
                fmt::format("{} drives the bus on this interface; send that owner the order, or end it first",
                            owner.empty() ? "another program" : owner),
                interface);
  }
  if (errno == EINVAL) return unusable("it cannot be locked; is it up (`ip link set dev NAME up`)?", errno);
  return unusable("it cannot be locked", errno);
}

InterfaceLock::~InterfaceLock() {
  if (fd_ >= 0) close(fd_);
}

InterfaceLock::InterfaceLock(InterfaceLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

}  // namespace gantry::devices
