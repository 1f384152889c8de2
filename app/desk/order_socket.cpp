#include "app/desk/order_socket.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <utility>

namespace gantry::desk {
namespace {

constexpr std::size_t kMostClients = 16;
constexpr std::size_t kLongestLine = 64 * 1024;

bool fill_address(sockaddr_un& address, const std::string& path) {
  address = {};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) return false;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  return true;
}

/// Takes the first line out of `buffer`.
std::optional<std::string> take_line(std::string& buffer) {
  const auto end = buffer.find('\n');
  if (end == std::string::npos) return std::nullopt;
  std::string line = buffer.substr(0, end);
  buffer.erase(0, end + 1);
  return line;
}

/// Appends what has arrived. False when the other side is gone.
bool read_some(int fd, std::string& buffer) {
  std::array<char, 4096> chunk{};
  for (;;) {
    const ssize_t n = recv(fd, chunk.data(), chunk.size(), MSG_DONTWAIT);
    if (n > 0) {
      buffer.append(chunk.data(), static_cast<std::size_t>(n));
      if (buffer.size() > 4 * kLongestLine) return false;
      continue;
    }
    return n < 0 && (errno == EAGAIN || errno == EINTR);
  }
}

}  // namespace

Result<std::unique_ptr<OrderSocket>> OrderSocket::listen(const std::string& path) {
  std::error_code ignored;
  if (const auto folder = std::filesystem::path(path).parent_path(); !folder.empty())
    std::filesystem::create_directories(folder, ignored);
  const std::string lock_path = path + ".lock";
  const int lock_fd = open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock_fd < 0)
    return fail(Fault::FileUnwritable, fmt::format("cannot write '{}': {}", lock_path, std::strerror(errno)), path);
  if (flock(lock_fd, LOCK_EX | LOCK_NB) != 0) {
    close(lock_fd);
    return fail(Fault::SecondOwner, "another `gantry up` owns this machine; send it orders, or end it first", path);
  }
  sockaddr_un address{};
  if (!fill_address(address, path)) {
    close(lock_fd);
    return fail(Fault::FileUnwritable, "the path is too long for a socket (at most 107 characters)", path);
  }
  unlink(path.c_str());  // left behind by an owner that was killed: its lock is free
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const mode_t old_mask = umask(0177);
  const bool bound = fd >= 0 && bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  umask(old_mask);
  if (!bound || ::listen(fd, 8) != 0) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) close(fd);
    close(lock_fd);
    return fail(Fault::FileUnwritable, fmt::format("cannot open the order socket: {}", why), path);
  }
  return std::unique_ptr<OrderSocket>(new OrderSocket(path, lock_fd, fd));
}

OrderSocket::~OrderSocket() {
  for (const Client& c : clients_) close(c.fd);
  close(listen_fd_);
  unlink(path_.c_str());
  close(lock_fd_);
}

void OrderSocket::accept_clients() {
  for (;;) {
    const int fd = accept4(listen_fd_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) return;
    if (clients_.size() >= kMostClients) {
      close(fd);
      continue;
    }
    clients_.push_back({next_id_++, fd, {}});
  }
}

std::optional<OrderSocket::Incoming> OrderSocket::poll() {
  accept_clients();
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    Client& client = clients_[i];
    const bool alive = read_some(client.fd, client.received);
    if (auto line = take_line(client.received)) return Incoming{client.id, std::move(*line)};
    if (!alive) {
      close(client.fd);
      clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(i--));
    }
  }
  return std::nullopt;
}

bool OrderSocket::send_line(const Client& client, const std::string& line) {
  const std::string text = line + "\n";
  return send(client.fd, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
}

void OrderSocket::reply(std::uint64_t client, const std::string& line) {
  for (const Client& c : clients_)
    if (c.id == client && !send_line(c, line)) shutdown(c.fd, SHUT_RDWR);
}

std::optional<OrderClient> OrderClient::connect(const std::string& path) {
  sockaddr_un address{};
  if (!fill_address(address, path)) return std::nullopt;
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return std::nullopt;
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    close(fd);
    return std::nullopt;
  }
  return OrderClient(fd);
}

OrderClient::~OrderClient() {
  if (fd_ >= 0) close(fd_);
}

OrderClient::OrderClient(OrderClient&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), gone_(other.gone_), received_(std::move(other.received_)) {}

bool OrderClient::send(const std::string& line) const {
  const std::string text = line + "\n";
  return ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
}

std::optional<std::string> OrderClient::read_line(Time timeout) {
  if (auto line = take_line(received_)) return line;
  pollfd waiting{fd_, POLLIN, 0};
  if (::poll(&waiting, 1, static_cast<int>(timeout.count() / 1'000'000)) > 0) gone_ = !read_some(fd_, received_);
  return take_line(received_);
}

}  // namespace gantry::desk
