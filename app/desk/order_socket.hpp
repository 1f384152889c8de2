// The local socket of the owner: JSON lines, open to the user who started it (file mode 0600), or to a group. The owner
// gives it one turn in every step of its run thread; a turn is a bounded amount of work, and no client can block it or
// another one.
//   Result<std::unique_ptr<OrderSocket>> opened = OrderSocket::listen("/run/user/1000/x/owner.sock");
//   for (const auto& in : (*opened)->turn(clock.now())) (*opened)->reply(in.client, "{...}");
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

#include "app/desk/order_line.hpp"
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
  static constexpr std::size_t kNamedRefusals = 32;        ///< in a turn: with the order and id of the line ...
  static constexpr std::size_t kLongestNamed = 1024;       ///< ... that is no longer than this
  static constexpr std::size_t kMostUnread = 256 * 1024;   ///< answers that a client has not read yet
  static constexpr Time kIdle = std::chrono::seconds(60);  ///< without a whole line and without an order under way

  /// One line.
  struct Incoming {
    std::uint64_t client = 0;
    Request request;
    /// Grows as lines arrive. What several clients say within one turn came in an order that nobody knows: there an
    /// order that stops something counts as the later one.
    std::uint64_t number = 0;
  };

  /// With `shared` the socket is there, open to the group that owns it by then (mode 0660), and `path` is a link to it.
  /// Fault::SecondOwner when another owner holds the lock beside one of them, FileUnwritable when one cannot be used.
  static Result<std::unique_ptr<OrderSocket>> listen(const std::string& path, const std::string& shared = "");
  ~OrderSocket();
  OrderSocket(const OrderSocket&) = delete;
  OrderSocket& operator=(const OrderSocket&) = delete;

  /// Takes new connections, sends what waits, reads what has arrived, and gives what is to be done now: orders that
  /// stop something, of each client one of each kind, in the turn in which they arrive; then at most one line of each
  /// client, in turn.
  std::vector<Incoming> turn(Time now);
  /// Behind all lines that have arrived up to now, and before those of the next turn.
  [[nodiscard]] std::uint64_t number() const { return (turn_ + 1) * kNumbersPerTurn; }
  /// One of the lines that wait for their turn; null: none is such.
  [[nodiscard]] const Incoming* waiting(const std::function<bool(const Incoming&)>& is_such) const;
  /// To one client; sent as it reads. A client that is gone is no error.
  void reply(std::uint64_t client, const std::string& line);
  /// An order of this client is carried out: it is not idle until that ends.
  void set_busy(std::uint64_t client, bool busy);
  /// When its last whole line arrived. Nothing when it has closed its side, also where lines of it are still unread.
  [[nodiscard]] std::optional<Time> heard(std::uint64_t client) const;
  /// Nobody is at the other end any more: it was closed, or its process is gone.
  [[nodiscard]] bool hung_up(std::uint64_t client) const;
  /// It is connected, or something that it has said waits.
  [[nodiscard]] bool knows(std::uint64_t client) const;
  [[nodiscard]] std::size_t clients() const { return clients_.size(); }

 private:
  static constexpr std::uint64_t kNumbersPerTurn = 2 * kStopKinds + 1;

  struct Arrived {
    std::size_t bytes = 0;
    Time at{};  ///< of the turn that has seen them first
  };
  struct Client {
    std::uint64_t id = 0;
    int fd = -1;
    Time heard{};
    std::deque<Arrived> unread_yet{};  ///< said, and left to later turns
    bool busy = false;
    bool asked = false;  ///< a line of it was handed over in this turn, and is answered behind it
    bool ended = false;  ///< it sends no more
    bool gone = false;   ///< it reads no more either
    std::string part{};  ///< of a line whose end has not come yet
    std::deque<Incoming> waiting{};
    unsigned stops = 0;          ///< kinds of such orders that were handed over in this turn, a bit each ...
    std::uint64_t numbered = 0;  ///< ... and what its next line is numbered behind the turn's first number
    std::string unread{};        ///< answers; what stands before `sent` is with the system
    std::size_t sent = 0;
  };
  /// A file beside a socket; while it is held no other owner is there.
  class Lock;
  OrderSocket(std::vector<std::string> paths, std::vector<std::unique_ptr<Lock>> locks, int listen_fd);

  void accept_clients(Time now, std::vector<Incoming>& urgent);
  bool make_room(Time now, std::vector<Incoming>& urgent);
  static void look(Client& client, Time now);
  static Time arrived(Client& client, std::size_t bytes, Time now);
  void read(Client& client, Time now, std::vector<Incoming>& urgent);
  void take_line(Client& client, const std::string& line, std::vector<Incoming>& urgent);
  void refuse_one_too_many(Client& client, const std::string& line);
  static void refuse(Client& client, std::string_view why);
  static void put(Client& client, const std::string& line);
  static void send_some(Client& client);
  void drop_the_dead(Time now);
  [[nodiscard]] Client* find(std::uint64_t id);
  [[nodiscard]] const Client* find(std::uint64_t id) const;

  std::vector<std::unique_ptr<Lock>> locks_;
  std::vector<std::string> paths_;  ///< the socket, and a link to it
  int listen_fd_;
  std::vector<Client> clients_;
  std::uint64_t next_id_ = 1, turn_ = 0;
  std::size_t named_refusals_ = 0;  ///< in this turn
  std::size_t first_ = 0;           ///< whose line is taken first in the next turn
};

}  // namespace gantry::desk
