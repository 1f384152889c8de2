#include "app/monitor/device_sockets.hpp"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <net/if.h>
#include <optional>
#include <string_view>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <system_error>
#include <unistd.h>

namespace gantry::monitor {
namespace {

char device_name[IFNAMSIZ];           // written once, before `confined` points to it
std::atomic<const char*> confined{};  // null: sockets are plain

bool is_network(int family) { return family == AF_INET || family == AF_INET6; }

/// The device that a network socket is bound to ("": to none), or nothing for other files.
std::optional<std::string> device_of(int fd) {
  int family = 0;
  socklen_t size = sizeof family;
  if (getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &family, &size) != 0 || !is_network(family)) return std::nullopt;
  char name[IFNAMSIZ]{};
  size = sizeof name;
  if (getsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, name, &size) != 0) return "";
  return std::string(name, strnlen(name, sizeof name));
}

}  // namespace

Result<void> confine_sockets(const std::string& device) {
  const char* before = confined.load(std::memory_order_acquire);
  if (before != nullptr && device != before)
    return fail(Fault::Refused, fmt::format("this process is confined to the device '{}' already", before), device);
  if (device.empty() || device.size() >= sizeof device_name)
    return fail(Fault::Usage, "'" + device + "' is no name of a network interface; see `ip link`");
  if (before == nullptr) {
    std::memcpy(device_name, device.c_str(), device.size() + 1);
    confined.store(device_name, std::memory_order_release);
  }
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0)
    return fail(Fault::DdsUnusable,
                fmt::format("no socket can be bound to the device '{}' ({}), and an open one is not used; it takes "
                            "Linux 5.7, or CAP_NET_RAW",
                            device, std::strerror(errno)),
                device);
  close(probe);
  return check_sockets(device);
}

Result<void> check_sockets(const std::string& device) try {
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const std::string number = entry.path().filename();
    int fd = -1;
    std::from_chars(number.data(), number.data() + number.size(), fd);
    const auto bound = device_of(fd);
    if (bound && *bound != device)
      return fail(
          Fault::DdsUnusable,
          fmt::format("a socket of this process is bound to {}, not to '{}': it could be reached from elsewhere",
                      bound->empty() ? "no device" : "'" + *bound + "'", device));
  }
  return {};
} catch (const std::system_error& error) {
  return fail(Fault::DdsUnusable, fmt::format("the sockets of this process cannot be checked: {}", error.what()));
}

}  // namespace gantry::monitor

/// The system's socket(), and the device before anybody can bind or connect it. DDS's library calls this one.
extern "C" int socket(int family, int type, int protocol) noexcept {
  const auto fd = static_cast<int>(syscall(SYS_socket, family, type, protocol));
  const char* device = gantry::monitor::confined.load(std::memory_order_acquire);
  if (fd < 0 || device == nullptr || !gantry::monitor::is_network(family)) return fd;
  const auto size = static_cast<socklen_t>(std::strlen(device));
  if (setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, device, size) == 0) return fd;
  const int why = errno;
  close(fd);
  errno = why;
  return -1;
}
