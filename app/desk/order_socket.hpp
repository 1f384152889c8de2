// The local door of the owner: a Unix socket with JSON lines, open to the user who started it (file mode 0600). The
// owner polls it from its run thread; nothing here blocks it. A lock file beside the socket refuses a second owner and
// outlives no process.
//   auto door = OrderSocket::listen("state/owner.sock");   while (auto in = door->poll()) door->reply(in->client,
//   "{...}");
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/error.hpp"

namespace gantry::desk {

class OrderSocket {
 public:
  struct Incoming {
    std::uint64_t client = 0;
    std::string line;
  };

  /// Fault::SecondOwner when another owner holds the lock, FileUnwritable when the path cannot be used.
  static Result<std::unique_ptr<OrderSocket>> listen(const std::string& path);
  ~OrderSocket();
  OrderSocket(const OrderSocket&) = delete;
  OrderSocket& operator=(const OrderSocket&) = delete;

  /// The next whole line of any client, if one is there.
  std::optional<Incoming> poll();
  /// To one client; one that does not read loses its connection, never the owner's time.
  void reply(std::uint64_t client, const std::string& line);

 private:
  struct Client {
    std::uint64_t id = 0;
    int fd = -1;
    std::string received;
  };
  OrderSocket(std::string path, int lock_fd, int listen_fd)
      : path_(std::move(path)), lock_fd_(lock_fd), listen_fd_(listen_fd) {}
  void accept_clients();
  static bool send_line(const Client& client, const std::string& line);

  std::string path_;
  int lock_fd_, listen_fd_;
  std::vector<Client> clients_;
  std::uint64_t next_id_ = 1;
};

/// The other side: a client of a running owner.
class OrderClient {
 public:
  /// Nothing when no owner listens at `path`.
  static std::optional<OrderClient> connect(const std::string& path);
  ~OrderClient();
  OrderClient(OrderClient&& other) noexcept;
  OrderClient& operator=(OrderClient&&) = delete;

  bool send(const std::string& line) const;
  /// The next line; nothing after `timeout` or when the owner is gone (then gone() says so).
  std::optional<std::string> read_line(Time timeout);
  [[nodiscard]] bool gone() const { return gone_; }

 private:
  explicit OrderClient(int fd) : fd_(fd) {}
  int fd_;
  bool gone_ = false;
  std::string received_;
};

}  // namespace gantry::desk
