#include "sim/machine/line_socket.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sys/socket.h>
#include <unistd.h>

namespace gantry::sim {

namespace {
constexpr std::size_t kMostLine = std::size_t{64} << 20;
}

LineSocket::~LineSocket() { ::close(fd_); }

bool LineSocket::fill() {
  buffer_.erase(0, taken_);
  taken_ = 0;
  char chunk[65536];
  ssize_t n = 0;
  do n = ::recv(fd_, chunk, sizeof chunk, 0);
  while (n < 0 && errno == EINTR);
  if (n <= 0) return false;
  buffer_.append(chunk, static_cast<std::size_t>(n));
  return true;
}

std::optional<std::string> LineSocket::read_line() {
  std::size_t searched = taken_;
  for (;;) {
    const std::size_t end = buffer_.find('\n', searched);
    if (end != std::string::npos) {
      std::string line = buffer_.substr(taken_, end - taken_);
      taken_ = end + 1;
      return line;
    }
    searched = buffer_.size() - taken_;
    if (searched > kMostLine || !fill()) return std::nullopt;
  }
}

bool LineSocket::read_exactly(std::span<std::uint8_t> to) {
  while (!to.empty()) {
    if (taken_ == buffer_.size() && !fill()) return false;
    const std::size_t n = std::min(to.size(), buffer_.size() - taken_);
    std::memcpy(to.data(), buffer_.data() + taken_, n);
    taken_ += n;
    to = to.subspan(n);
  }
  return true;
}

bool LineSocket::write(const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::send(fd_, at, size, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace gantry::sim
