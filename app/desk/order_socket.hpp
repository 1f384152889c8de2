// The local socket of the owner: JSON lines, open to the user who started it (file mode 0600), or to a group. The owner
// gives it one turn in every step of its run thread; a turn is a bounded amount of work, and no client can block it or
// another one.
//   auto door = OrderSocket::listen("/run/user/1000/x/owner.sock", is_urgent);
//   for (const auto& in : door->turn(clock.now())) door->reply(in.client, "{...}");
// What is bounded, and what becomes of a client that goes beyond, stands in docs/owner-socket.md.
#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "core/error.hpp"

namespace gantry::desk {

class OrderSocket {
 public:
  static constexpr std::size_t kMostClients = 16;
  static constexpr std::size_t kLinesPerTurn = 8;          ///< of all clients together, urgent ones not counted
  static constexpr std::size_t kMostWaiting = 32;          ///< lines of one client that wait for their turn
  static constexpr std::size_t kBytesPerTurn = 64 * 1024;  ///< read of one client ...
  static constexpr std::size_t kLinesReadPerTurn = 256;    ///< ... until it was this many lines; the chunk is finished
  static constexpr std::size_t kLongestLine = 64 * 1024;   ///< without its newline
  static constexpr std::size_t kMostUnread = 256 * 1024;   ///< answers that a client has not read yet
  static constexpr Time kIdle = std::chrono::seconds(60);  ///< without a whole line and without an order under way

  struct Incoming {
    std::uint64_t client = 0;
    std::string line;
    std::uint64_t number = 0;  ///< in the order in which lines arrived, of all clients
  };

  /// `urgent` says of a line that it must not wait for anything: it is handed over in the turn in which it arrives,
  /// before all others; of several that one client sends at once, the first. With `shared` the socket is there, open to
  /// the group that owns it by then (mode 0660), and `path` is a link to it. Fault::SecondOwner when another owner
  /// holds the lock beside one of them, FileUnwritable when one cannot be used.
  static Result<std::unique_ptr<OrderSocket>> listen(const std::string& path,
                                                     std::function<bool(std::string_view)> urgent,
                                                     const std::string& shared = "");
  ~OrderSocket();
  OrderSocket(const OrderSocket&) = delete;
  OrderSocket& operator=(const OrderSocket&) = delete;

  /// Takes new connections, sends what waits, reads what has arrived, and gives what is to be done now: urgent lines,
  /// then at most one line of each client, in turn.
  std::vector<Incoming> turn(Time now);
  /// To one client; sent as it reads. A client that is gone is no error.
  void reply(std::uint64_t client, const std::string& line);
  /// An order of this client is carried out: it is not idle until that ends.
  void set_busy(std::uint64_t client, bool busy);
  /// When its last whole line arrived. Nothing when it has closed its side.
  [[nodiscard]] std::optional<Time> heard(std::uint64_t client) const;
  /// It is connected, or something that it has said waits.
  [[nodiscard]] bool knows(std::uint64_t client) const;
  [[nodiscard]] std::size_t clients() const { return clients_.size(); }

 private:
  struct Client {
    std::uint64_t id = 0;
    int fd = -1;
    Time heard{};
    bool busy = false;
    bool asked = false;  ///< a line of it was handed over in this turn, and is answered behind it
    bool ended = false;  ///< it sends no more
    bool gone = false;   ///< it reads no more either
    std::string part{};  ///< of a line whose end has not come yet
    std::deque<Incoming> waiting{};
    std::string unread{};  ///< answers; what stands before `sent` is with the system
    std::size_t sent = 0;
  };
  /// A file beside a socket; while it is held no other owner is there.
  class Lock;
  OrderSocket(std::vector<std::string> paths, std::vector<std::unique_ptr<Lock>> locks, int listen_fd,
              std::function<bool(std::string_view)> urgent);

  void accept_clients(Time now, std::vector<Incoming>& urgent);
  bool make_room(Time now, std::vector<Incoming>& urgent);
  void read(Client& client, Time now, std::vector<Incoming>& urgent);
  void take_line(Client& client, std::string line, bool& urgent_taken, std::vector<Incoming>& urgent);
  static void refuse(Client& client, std::string_view why);
  static void put(Client& client, const std::string& line);
  static void send_some(Client& client);
  void drop_the_dead(Time now);
  [[nodiscard]] Client* find(std::uint64_t id);
  [[nodiscard]] const Client* find(std::uint64_t id) const;

  std::vector<std::unique_ptr<Lock>> locks_;
  std::vector<std::string> paths_;  ///< the socket, and a link to it
  int listen_fd_;
  std::function<bool(std::string_view)> urgent_;
  std::vector<Client> clients_;
  std::uint64_t next_id_ = 1, next_number_ = 1;
  std::size_t first_ = 0;  ///< whose line is taken first in the next turn
};

}  // namespace gantry::desk
