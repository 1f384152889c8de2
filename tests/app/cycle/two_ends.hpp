// A socket with both its ends here: what is sent into `in()` can be read as whole frames, as from a network interface.
#pragma once
#include <array>
#include <cstddef>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <vector>

namespace gantry::test {

class TwoEnds {
 public:
  TwoEnds() {
    if (::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0, ends_.data()) != 0) ends_ = {-1, -1};
  }
  ~TwoEnds() {
    ::close(ends_[0]);
    ::close(ends_[1]);
  }
  TwoEnds(const TwoEnds&) = delete;
  TwoEnds& operator=(const TwoEnds&) = delete;

  [[nodiscard]] int in() const { return ends_[0]; }
  /// The next frame; empty when none has come within `patience_ms`.
  std::vector<std::byte> read(int patience_ms) const {
    pollfd p{ends_[1], POLLIN, 0};
    if (::poll(&p, 1, patience_ms) <= 0) return {};
    std::vector<std::byte> frame(2000);
    const ssize_t got = ::recv(ends_[1], frame.data(), frame.size(), 0);
    frame.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return frame;
  }

 private:
  std::array<int, 2> ends_{};
};

}  // namespace gantry::test
