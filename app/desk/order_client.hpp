// The other side of the order socket: a client of an owner that runs.
//   auto owner = OrderClient::connect(state + "/owner.sock");   owner->send(line); owner->read_line(milliseconds(100));
#pragma once
#include <deque>
#include <optional>
#include <string>

#include "core/clock.hpp"
#include "core/error.hpp"

namespace gantry::desk {

class OrderClient {
 public:
  /// Nothing when nobody listens at `path`. Fault::OwnerSilent when who listens takes no connection within
  /// Patience::kSilence. Fault::Refused, naming whose it is, when the socket or its folder belongs
  /// to another user who lets nobody in.
  static Result<std::optional<OrderClient>> connect(const std::string& path);
  ~OrderClient();
  OrderClient(OrderClient&& other) noexcept;
  OrderClient& operator=(OrderClient&&) = delete;

  /// False when the owner is gone, or takes nothing for Patience::kSilence.
  bool send(const std::string& line);
  /// The next line; nothing after `timeout` or when the owner is gone (then gone() says so).
  std::optional<std::string> read_line(Time timeout);
  /// The owner has closed the connection, and every line that it had sent was read.
  [[nodiscard]] bool gone() const { return gone_ && lines_.empty(); }

  /// Whether the owner's process has ended, which is waited for. Nothing: it cannot be seen from here (another PID
  /// namespace).
  [[nodiscard]] std::optional<bool> process_ended(Time timeout) const;

  /// Of an owner that says nothing: what can be seen of its process, and that nobody knows what became of the order.
  [[nodiscard]] Error silent() const;

 private:
  explicit OrderClient(int fd);
  void read_some();

  int fd_, process_;  ///< -1: it cannot be seen
  bool gone_ = false;
  std::string part_;  ///< of a line whose end has not come yet
  std::deque<std::string> lines_;
};

}  // namespace gantry::desk
