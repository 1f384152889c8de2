#include "sim/machine/world_client.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <mutex>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/absolute_path.hpp"
#include "sim/machine/line_socket.hpp"
#include "sim/world/board.hpp"
#include "sim/world/world_json.hpp"

namespace gantry::sim {

using nlohmann::json;

namespace {

/// A world that hangs must not hang its client: far above every answer's time.
constexpr timeval kPatience{10, 0};

Result<std::unique_ptr<LineSocket>> connect_to(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    return fail(Fault::WorldUnreachable, "the socket's path is too long", path);
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  // A world that hangs takes no connection: where its queue is full, a connect(2) that blocks would wait for ever.
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  auto socket = std::make_unique<LineSocket>(fd);
  if (fd < 0 || ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return fail(
        Fault::WorldUnreachable,
        fmt::format("nobody answers there ({}); start `gantry sim --world {}` first", std::strerror(errno), path),
        path);
  ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) & ~O_NONBLOCK);
  ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
  ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &kPatience, sizeof kPatience);
  return socket;
}

/// Between two questions nothing is due: what can be read then is the end.
bool ended(const LineSocket& socket) {
  pollfd p{socket.fd(), POLLIN | POLLRDHUP, 0};
  return ::poll(&p, 1, 0) != 0;
}

}  // namespace

/// The conversation: one question at a time, from any thread.
class WorldClient::Link final : public vision::Camera {
 public:
  Link(std::unique_ptr<LineSocket> socket, std::string path) : socket_(std::move(socket)), path_(std::move(path)) {}

  /// Looks for the world again where it has been lost.
  Result<void> renew() {
    const std::scoped_lock lock(mutex_);
    if (!gone_ && !ended(*socket_)) return {};
    auto socket = connect_to(path_);
    if (!socket) return tl::unexpected(socket.error());
    {
      const std::scoped_lock replacing(replacing_);
      socket_ = std::move(*socket);
    }
    gone_ = false;
    return {};
  }

  /// Whoever waits for an answer holds `mutex_`, and finds that the conversation has ended.
  void give_up() {
    const std::scoped_lock replacing(replacing_);
    ::shutdown(socket_->fd(), SHUT_RDWR);
  }

  Result<json> ask(const json& question) {
    const std::scoped_lock lock(mutex_);
    return ask_locked(question);
  }

  std::uint64_t latest() override {
    const auto a = ask({{"do", "latest"}});
    if (a) latest_ = a->value("value", latest_);
    return latest_;
  }

  Result<vision::Frame> fetch(std::uint64_t after, Time timeout) override {
    const std::scoped_lock lock(mutex_);
    const auto a = ask_locked({{"do", "fetch"}, {"after", after}, {"timeout_ns", timeout.count()}});
    if (!a) return tl::unexpected(a.error());
    vision::Frame frame{a->value("counter", std::uint64_t{0}), {a->value("width", 0), a->value("height", 0), {}}};
    const auto bytes = a->value("bytes", std::size_t{0});
    if (bytes != static_cast<std::size_t>(frame.image.width) * static_cast<std::size_t>(frame.image.height))
      return gone();
    frame.image.pixels.resize(bytes);
    if (!socket_->read_exactly(frame.image.pixels)) return gone();
    return frame;
  }

 private:
  /// Until the next job: a late answer would be taken for that to the next question, and each question would wait anew.
  tl::unexpected<Error> gone() {
    gone_ = true;
    return fail(Fault::WorldUnreachable,
                "the simulated machine's world has stopped answering; the next job looks for it again", path_);
  }
  Result<json> ask_locked(const json& question) {
    if (gone_ || !socket_->write(question.dump(-1, ' ', false, json::error_handler_t::replace) + "\n")) return gone();
    const auto line = socket_->read_line();
    if (!line) return gone();
    auto a = parse_json(*line);
    if (!a || !a->is_object()) return gone();
    if (!a->value("ok", false))
      return fail(static_cast<Fault>(a->value("fault", 0)), a->value("message", std::string()),
                  a->value("where", std::string()));
    return a;
  }

  std::unique_ptr<LineSocket> socket_;
  std::string path_;
  std::mutex mutex_;
  std::mutex replacing_;  ///< of `socket_`
  std::uint64_t latest_ = 0;
  bool gone_ = false;
};

namespace {

template <class T>
Result<std::vector<T>> list_in(const Result<json>& answer, const char* name, Result<T> (*read)(const json&)) {
  if (!answer) return tl::unexpected(answer.error());
  std::vector<T> out;
  for (const json& item : answer->value(name, json::array())) {
    auto each = read(item);
    if (!each) return tl::unexpected(each.error());
    out.push_back(std::move(*each));
  }
  return out;
}
Result<void> done(const Result<json>& answer) {
  if (!answer) return tl::unexpected(answer.error());
  return {};
}
template <class T>
Result<T> value(const Result<json>& answer) {
  if (!answer) return tl::unexpected(answer.error());
  return answer->value("value", T{});
}

}  // namespace

WorldClient::WorldClient(std::unique_ptr<Link> link) : link_(std::move(link)) {}
WorldClient::~WorldClient() = default;

Result<std::unique_ptr<WorldClient>> WorldClient::connect(const std::string& path) {
  auto socket = connect_to(path);
  if (!socket) return tl::unexpected(socket.error());
  return std::unique_ptr<WorldClient>(new WorldClient(std::make_unique<Link>(std::move(*socket), path)));
}

vision::Camera& WorldClient::camera() { return *link_; }
Result<void> WorldClient::load_board(const recipes::Recipe& recipe) {
  return done(link_->ask({{"do", "load_board"}, {"plan", to_json(board_plan(recipe))}}));
}
Result<bool> WorldClient::holds_board(const recipes::Recipe& recipe) {
  if (auto there = link_->renew(); !there) return tl::unexpected(there.error());
  return value<bool>(link_->ask({{"do", "holds_board"}, {"plan", to_json(board_plan(recipe))}}));
}
Result<void> WorldClient::begin_job() { return done(link_->ask({{"do", "begin_job"}})); }
Result<std::vector<Deposit>> WorldClient::deposits() {
  return list_in<Deposit>(link_->ask({{"do", "deposits"}}), "deposits", deposit_from_json);
}
Result<std::vector<Collision>> WorldClient::collisions() {
  return list_in<Collision>(link_->ask({{"do", "collisions"}}), "collisions", collision_from_json);
}
Result<void> WorldClient::write_deposits(const std::string& path) {
  // The other process has its own working directory.
  const auto whole = absolute_path(path);
  return whole ? done(link_->ask({{"do", "write_deposits"}, {"path", *whole}})) : tl::unexpected(whole.error());
}
Result<std::string> WorldClient::placement() { return value<std::string>(link_->ask({{"do", "placement"}})); }
Result<void> WorldClient::add_script(std::string_view yaml) {
  return done(link_->ask({{"do", "add_script"}, {"yaml", yaml}}));
}
Result<std::vector<std::string>> WorldClient::script_left(Machine machine) {
  return value<std::vector<std::string>>(
      link_->ask({{"do", "script_left"}, {"machine_ends", machine == Machine::Ends}}));
}
void WorldClient::give_up() { link_->give_up(); }

}  // namespace gantry::sim
