#include "app/desk/order_client.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <poll.h>
#include <pwd.h>
#include <string_view>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>
#include <utility>

#include "app/desk/patience.hpp"
#include "app/desk/socket_address.hpp"

namespace gantry::desk {
namespace {

/// Somebody has sent it SIGSTOP, or a debugger holds it: proc(5), the state behind the name in parentheses.
bool is_stopped(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string all;
  std::getline(file, all);
  const auto name_ends = all.rfind(')');
  if (name_ends == std::string::npos || name_ends + 2 >= all.size()) return false;
  const char state = all[name_ends + 2];
  return state == 'T' || state == 't';
}

/// "user 'anna'" who owns the last part of `path` that can be looked at.
std::string whose(const std::string& path) {
  for (std::filesystem::path at = path; !at.empty(); at = at.parent_path()) {
    struct stat found {};
    if (lstat(at.c_str(), &found) == 0) {
      const passwd* user = getpwuid(found.st_uid);
      return user != nullptr ? fmt::format("user '{}'", user->pw_name) : fmt::format("user {}", found.st_uid);
    }
    if (at == at.parent_path()) break;
  }
  return "another user";
}

/// The process that listens at the other end of a connection; 0: it is not known here.
pid_t owner_of(int fd) {
  ucred owner{};
  socklen_t size = sizeof(owner);
  return getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &owner, &size) == 0 ? owner.pid : 0;
}

}  // namespace

Result<std::optional<OrderClient>> OrderClient::connect(const std::string& path) {
  const auto address = socket_address(path);
  if (!address) return tl::unexpected(address.error());
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return fail(Fault::Internal, fmt::format("no socket can be made: {}", std::strerror(errno)), path);
  // A connection to an owner that is stopped, and what is sent to it, would wait for ever.
  const timeval patience{.tv_sec = Patience::kSilence / std::chrono::seconds(1), .tv_usec = 0};
  setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&*address), sizeof(*address)) == 0)
    return std::optional<OrderClient>(OrderClient(fd));
  const int why = errno;
  close(fd);
  if (why == ENOENT || why == ECONNREFUSED || why == ENOTDIR) return std::optional<OrderClient>();
  if (why == EACCES || why == EPERM)
    return fail(
        Fault::Refused,
        fmt::format(
            "the owner's socket belongs to {}, and you may not give it orders; work as that user, as a member "
            "of the socket's group where it has one (`sudo adduser $USER gantry`, then log in again), or with a "
            "state folder of your own",
            whose(path)),
        path);
  if (why == EAGAIN || why == EINPROGRESS)
    return fail(Fault::OwnerSilent, "it has taken no connection for 5 s, and others wait for one already", path);
  return fail(Fault::Refused, fmt::format("the owner cannot be reached: {}", std::strerror(why)), path);
}

/// From now on, so that its number cannot be another process's.
OrderClient::OrderClient(int fd)
    : fd_(fd), process_(owner_of(fd) > 0 ? static_cast<int>(syscall(SYS_pidfd_open, owner_of(fd), 0)) : -1) {}

OrderClient::~OrderClient() {
  for (const int fd : {fd_, process_})
    if (fd >= 0) close(fd);
}

OrderClient::OrderClient(OrderClient&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      process_(std::exchange(other.process_, -1)),
      gone_(other.gone_),
      part_(std::move(other.part_)),
      lines_(std::move(other.lines_)) {}

bool OrderClient::send(const std::string& line) {
  const std::string text = line + "\n";
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = ::send(fd_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    sent += static_cast<std::size_t>(n);
  }
  return true;
}

std::optional<bool> OrderClient::process_ended(Time timeout) const {
  if (process_ < 0) return std::nullopt;
  pollfd ends{process_, POLLIN, 0};
  return ::poll(&ends, 1, static_cast<int>(timeout / milliseconds(1))) > 0;
}

Error OrderClient::silent() const {
  const pid_t owner = owner_of(fd_);
  std::string who = "the owner";
  if (owner > 0) who += fmt::format(" (process {})", owner);
  if (owner > 0 && is_stopped(owner)) who += fmt::format(" is stopped (`kill -CONT {}` lets it go on), and", owner);
  return {Fault::OwnerSilent,
          fmt::format("{} has said nothing for {} s; nobody knows what became of the order", who,
                      Patience::kSilence / std::chrono::seconds(1)),
          ""};
}

void OrderClient::read_some() {
  std::array<char, 16384> chunk{};
  const ssize_t n = recv(fd_, chunk.data(), chunk.size(), MSG_DONTWAIT);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n <= 0) {
    gone_ = true;
    return;
  }
  std::string_view bytes(chunk.data(), static_cast<std::size_t>(n));
  for (auto end = bytes.find('\n'); end != std::string_view::npos; end = bytes.find('\n')) {
    part_.append(bytes.substr(0, end));
    bytes.remove_prefix(end + 1);
    lines_.push_back(std::exchange(part_, {}));
  }
  part_.append(bytes);
}

std::optional<std::string> OrderClient::read_line(Time timeout) {
  if (lines_.empty() && !gone_) {
    pollfd waiting{fd_, POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(timeout.count() / 1'000'000)) > 0) read_some();
  }
  if (lines_.empty()) return std::nullopt;
  std::string line = std::move(lines_.front());
  lines_.pop_front();
  return line;
}

}  // namespace gantry::desk
