#include "app/desk/order_socket.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "app/desk/answer.hpp"
#include "app/desk/socket_address.hpp"

namespace gantry::desk {
namespace {

constexpr int kBacklog = 64;
constexpr int kAcceptsPerTurn = 16;

/// The lock file beside the socket. -1 with errno when it cannot be had.
int open_lock(const std::string& path) { return open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600); }

int bind_socket(const sockaddr_un& address, bool for_group) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  const mode_t old_mask = umask(for_group ? 0117 : 0177);
  const bool bound = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  umask(old_mask);
  if (bound && listen(fd, kBacklog) == 0) return fd;
  const int why = errno;
  close(fd);
  errno = why;
  return -1;
}

Json refusal(std::string_view why) { return failure({Error{Fault::Refused, std::string(why), ""}}); }

std::size_t unread_bytes(int fd) {
  int bytes = 0;
  return ioctl(fd, FIONREAD, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

/// Those of `events` that are so now: the other side may have ended with much of it unread.
bool is_so(int fd, short events) {
  pollfd p{fd, events, 0};
  return poll(&p, 1, 0) > 0 && (p.revents & events) != 0;
}

}  // namespace

class OrderSocket::Lock {
 public:
  static Result<std::unique_ptr<Lock>> take(const std::string& socket) {
    const std::string path = socket + ".lock";
    auto lock = std::make_unique<Lock>(open_lock(path));
    if (lock->fd_ < 0)
      return fail(Fault::FileUnwritable, fmt::format("cannot write '{}': {}", path, std::strerror(errno)), socket);
    if (flock(lock->fd_, LOCK_EX | LOCK_NB) != 0) {
      std::string words = "another `gantry up` owns this machine; send it orders, or end it first";
      struct stat found {};
      if (fstat(lock->fd_, &found) == 0 && found.st_uid != geteuid())
        words = fmt::format(
            "another program owns this machine, or keeps it from others: '{}' belongs to user {}; end that user's "
            "`gantry up`, or take a folder in which that user may not write",
            path, found.st_uid);
      return fail(Fault::SecondOwner, std::move(words), socket);
    }
    return lock;
  }
  explicit Lock(int fd) : fd_(fd) {}
  ~Lock() {
    if (fd_ >= 0) close(fd_);
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int fd_;
};

namespace {

/// Nothing, a socket, or a link to one, as an owner that was killed leaves them.
bool may_be_replaced(const std::string& path) {
  struct stat there {};
  if (lstat(path.c_str(), &there) != 0 || S_ISSOCK(there.st_mode)) return true;
  return S_ISLNK(there.st_mode) && (stat(path.c_str(), &there) != 0 || S_ISSOCK(there.st_mode));
}

}  // namespace

OrderSocket::OrderSocket(std::vector<std::string> paths, std::vector<std::unique_ptr<Lock>> locks, int listen_fd)
    : locks_(std::move(locks)), paths_(std::move(paths)), listen_fd_(listen_fd) {}

Result<std::unique_ptr<OrderSocket>> OrderSocket::listen(const std::string& path, const std::string& shared) {
  std::vector<std::string> paths{path};
  if (!shared.empty()) paths.insert(paths.begin(), shared);
  const auto address = socket_address(paths.front());
  if (!address) return tl::unexpected(address.error());
  std::vector<std::unique_ptr<Lock>> locks;
  for (const std::string& each : paths)
    if (!may_be_replaced(each))
      return fail(Fault::FileUnwritable, "something that is no socket stands there; choose another path", each);
  for (const std::string& each : paths) {
    auto lock = Lock::take(each);
    if (!lock) return tl::unexpected(lock.error());
    locks.push_back(*std::move(lock));
  }
  for (const std::string& each : paths) unlink(each.c_str());  // of an owner that was killed: its locks are free
  const int fd = bind_socket(*address, !shared.empty());
  if (fd < 0)
    return fail(Fault::FileUnwritable, fmt::format("cannot open the order socket: {}", std::strerror(errno)),
                paths.front());
  std::unique_ptr<OrderSocket> door(new OrderSocket(paths, std::move(locks), fd));
  if (!shared.empty() && symlink(shared.c_str(), path.c_str()) != 0)
    return fail(Fault::FileUnwritable, fmt::format("cannot link to the order socket: {}", std::strerror(errno)), path);
  return door;
}

OrderSocket::~OrderSocket() {
  for (Client& c : clients_) {
    send_some(c);  // the last answers, as far as they can be had without waiting
    close(c.fd);
  }
  close(listen_fd_);
  for (const std::string& each : paths_) unlink(each.c_str());
}

// ---- one turn ----

std::vector<OrderSocket::Incoming> OrderSocket::turn(Time now) {
  std::vector<Incoming> lines;
  ++turn_;
  named_refusals_ = 0;
  for (Client& c : clients_) c.asked = false, c.stops = 0, c.numbered = 0;
  accept_clients(now, lines);
  for (Client& c : clients_) {
    send_some(c);
    read(c, now, lines);
  }
  const std::size_t most = lines.size() + kLinesPerTurn, everyone = clients_.size();
  std::size_t i = 0;
  for (; i < everyone && lines.size() < most; ++i) {
    Client& c = clients_[(first_ + i) % everyone];
    // Who does not read is not asked what else it wants.
    if (c.waiting.empty() || c.unread.size() - c.sent > kMostUnread / 2) continue;
    lines.push_back(std::move(c.waiting.front()));
    c.waiting.pop_front();
    c.asked = true;
  }
  if (everyone > 0) first_ = (first_ + std::max<std::size_t>(i, 1)) % everyone;
  drop_the_dead(now);
  return lines;
}

void OrderSocket::accept_clients(Time now, std::vector<Incoming>& urgent) {
  for (int i = 0; i < kAcceptsPerTurn; ++i) {
    const int fd = accept4(listen_fd_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd < 0) return;
    Client client{.id = next_id_++, .fd = fd, .heard = now};
    if (clients_.size() >= kMostClients && !make_room(now, urgent)) {
      refuse(client, "every place is taken by a client whose order is carried out; try again");
      send_some(client);
      close(fd);
      continue;
    }
    clients_.push_back(std::move(client));
  }
}

/// Drops the client that has been idle for longest; one with lines that wait for their turn only where all have such.
/// False when each has an order under way.
bool OrderSocket::make_room(Time now, std::vector<Incoming>& urgent) {
  Client* idle = nullptr;
  const auto wanted = [](const Client& c) { return std::pair(c.asked || !c.waiting.empty(), c.heard); };
  for (Client& c : clients_) {
    if (c.busy) continue;
    read(c, now, urgent);  // what it has just said is not lost with it
    if (idle == nullptr || wanted(c) < wanted(*idle)) idle = &c;
  }
  if (idle == nullptr) return false;
  refuse(*idle, "dropped as the connection that was idle for longest: another client needed the place");
  send_some(*idle);
  close(idle->fd);
  clients_.erase(clients_.begin() + (idle - clients_.data()));
  return true;
}

/// What of a burst is left to later turns was said up to this one.
void OrderSocket::look(Client& client, Time now) {
  std::size_t new_bytes = unread_bytes(client.fd);
  for (const Arrived& before : client.unread_yet) new_bytes -= std::min(new_bytes, before.bytes);
  if (new_bytes > 0) client.unread_yet.push_back({new_bytes, now});
}

/// When the last of the next `bytes` that are read arrived.
Time OrderSocket::arrived(Client& client, std::size_t bytes, Time now) {
  Time at = now;
  while (bytes > 0 && !client.unread_yet.empty()) {
    Arrived& first = client.unread_yet.front();
    if (first.bytes > bytes) {
      first.bytes -= bytes;
      return first.at;
    }
    bytes -= first.bytes;
    at = first.at;
    client.unread_yet.pop_front();
  }
  return bytes > 0 ? now : at;
}

void OrderSocket::read(Client& client, Time now, std::vector<Incoming>& urgent) {
  std::array<char, 4096> chunk{};
  std::size_t lines = 0;
  for (std::size_t taken = 0; taken < kBytesPerTurn && lines < kLinesReadPerTurn && !client.ended;) {
    const ssize_t n = recv(client.fd, chunk.data(), std::min(chunk.size(), kBytesPerTurn - taken), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n <= 0) {
      client.ended = true;
      return;
    }
    taken += static_cast<std::size_t>(n);
    std::string_view bytes(chunk.data(), static_cast<std::size_t>(n));
    for (auto end = bytes.find('\n'); end != std::string_view::npos; end = bytes.find('\n')) {
      client.heard = arrived(client, end + 1, now);
      ++lines;
      client.part.append(bytes.substr(0, end));
      bytes.remove_prefix(end + 1);
      if (client.part.size() > kLongestLine) break;
      take_line(client, std::exchange(client.part, {}), urgent);
    }
    arrived(client, bytes.size(), now);
    if (client.part.size() <= kLongestLine) client.part.append(bytes);
    if (client.part.size() <= kLongestLine) continue;
    refuse(client, "a line is at most 64 KiB long");
    client.ended = true;
    client.part.clear();
  }
  look(client, now);
}

/// What is not to be taken anyway is read only where it may be an order that stops something.
void OrderSocket::take_line(Client& client, const std::string& line, std::vector<Incoming>& urgent) {
  if (line.empty()) return;
  const bool room = !client.gone && client.waiting.size() < kMostWaiting;
  if (room || may_stop(line)) {
    Request request = read_request(line);
    const auto stop = request.order ? stop_kind(request.order->kind) : std::nullopt;
    if (stop && (client.stops >> *stop & 1u) == 0) {
      client.stops |= 1u << *stop;
      client.asked = true;
      urgent.push_back({client.id, std::move(request), turn_ * kNumbersPerTurn + client.numbered + 1});
      client.numbered += 2;
      return;
    }
    if (room) {
      client.waiting.push_back({client.id, std::move(request), turn_ * kNumbersPerTurn + client.numbered});
      return;
    }
  }
  if (!client.gone) refuse_one_too_many(client, line);  // who is gone would not hear it
}

/// In a flood there are thousands of them.
void OrderSocket::refuse_one_too_many(Client& client, const std::string& line) {
  static const Json kTooMany = refusal("32 orders of this client wait already; read their answers first");
  static const std::string kNameless = to_line(kTooMany);
  const bool named = line.size() <= kLongestNamed && named_refusals_++ < kNamedRefusals;
  put(client, named ? to_line(answer_to(read_request(line), kTooMany)) : kNameless);
}

void OrderSocket::drop_the_dead(Time now) {
  for (Client& c : clients_) {
    const bool nothing_to_do = c.waiting.empty() && !c.busy && !c.asked;
    const bool nothing_to_say = c.gone || c.sent == c.unread.size();
    if (nothing_to_do && !c.ended && now - c.heard > kIdle) {
      refuse(c, "idle for a minute; connect again when you need the machine");
      send_some(c);
      c.ended = c.gone = true;
    }
    if ((c.gone && c.waiting.empty()) || (c.ended && nothing_to_do && nothing_to_say)) close(std::exchange(c.fd, -1));
  }
  std::erase_if(clients_, [](const Client& c) { return c.fd < 0; });
}

// ---- answers ----

void OrderSocket::reply(std::uint64_t client, const std::string& line) {
  if (Client* c = find(client)) {
    put(*c, line);
    send_some(*c);
  }
}

void OrderSocket::put(Client& client, const std::string& line) {
  if (client.gone) return;
  const auto too_much = [&] { return client.unread.size() - client.sent + line.size() + 1 > kMostUnread; };
  if (too_much()) send_some(client);
  if (too_much()) {
    client.ended = client.gone = true;  // it does not read: nothing more can be said to it
    client.waiting.clear();
    return;
  }
  if (client.sent > client.unread.size() / 2) client.unread.erase(0, std::exchange(client.sent, 0));
  client.unread.append(line).push_back('\n');
}

void OrderSocket::send_some(Client& client) {
  while (!client.gone && client.sent < client.unread.size()) {
    const ssize_t n = send(client.fd, client.unread.data() + client.sent, client.unread.size() - client.sent,
                           MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n < 0)
      client.ended = client.gone = true;
    else
      client.sent += static_cast<std::size_t>(n);
  }
}

void OrderSocket::refuse(Client& client, std::string_view why) { put(client, to_line(refusal(why))); }

const OrderSocket::Client* OrderSocket::find(std::uint64_t id) const {
  const auto found = std::find_if(clients_.begin(), clients_.end(), [&](const Client& c) { return c.id == id; });
  return found == clients_.end() ? nullptr : &*found;
}

OrderSocket::Client* OrderSocket::find(std::uint64_t id) { return const_cast<Client*>(std::as_const(*this).find(id)); }

void OrderSocket::set_busy(std::uint64_t client, bool busy) {
  if (Client* c = find(client)) c->busy = busy;
}

bool OrderSocket::knows(std::uint64_t client) const { return find(client) != nullptr; }

std::optional<Time> OrderSocket::heard(std::uint64_t client) const {
  const Client* c = find(client);
  return c != nullptr && !c->ended && !is_so(c->fd, POLLRDHUP) ? std::optional(c->heard) : std::nullopt;
}

bool OrderSocket::hung_up(std::uint64_t client) const {
  const Client* c = find(client);
  return c == nullptr || c->gone || is_so(c->fd, POLLHUP);
}

const OrderSocket::Incoming* OrderSocket::waiting(const std::function<bool(const Incoming&)>& is_such) const {
  for (const Client& c : clients_)
    for (const Incoming& in : c.waiting)
      if (is_such(in)) return &in;
  return nullptr;
}

}  // namespace gantry::desk
