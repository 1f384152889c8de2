#include "sim/machine/world_server.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "sim/world/board.hpp"
#include "sim/world/world_json.hpp"

namespace gantry::sim {

using nlohmann::json;

namespace {

json refused(const Error& e) {
  return {{"ok", false}, {"fault", static_cast<int>(e.fault)}, {"message", e.message}, {"where", e.where}};
}

template <class T>
json list_of(const Result<std::vector<T>>& items, const char* name) {
  if (!items) return refused(items.error());
  json list = json::array();
  for (const T& item : *items) list.push_back(to_json(item));
  return {{"ok", true}, {name, std::move(list)}};
}
json done(const Result<void>& r) { return r ? json{{"ok", true}} : refused(r.error()); }
template <class T>
json value(const Result<T>& r) {
  return r ? json{{"ok", true}, {"value", *r}} : refused(r.error());
}

/// What a question gives: a line, and for a frame its pixels.
struct Answer {
  json line;
  std::vector<std::uint8_t> pixels;
};

Answer fetch(vision::Camera& camera, const json& q) {
  auto frame = camera.fetch(q.at("after").get<std::uint64_t>(), Time(q.at("timeout_ns").get<std::int64_t>()));
  if (!frame) return {refused(frame.error()), {}};
  return {{{"ok", true},
           {"counter", frame->counter},
           {"width", frame->image.width},
           {"height", frame->image.height},
           {"bytes", frame->image.pixels.size()}},
          std::move(frame->image.pixels)};
}

Answer answer(SimulatedMachine& world, const json& q) {
  const std::string what = q.at("do").get<std::string>();
  if (what == "latest") return {{{"ok", true}, {"value", world.camera().latest()}}, {}};
  if (what == "fetch") return fetch(world.camera(), q);
  if (what == "load_board" || what == "holds_board") {
    auto plan = plan_from_json(q.at("plan"));
    if (!plan) return {refused(plan.error()), {}};
    if (what == "holds_board") return {value(world.holds_board(*plan)), {}};
    return {done(world.load_board(std::move(*plan))), {}};
  }
  if (what == "begin_job") return {done(world.begin_job()), {}};
  if (what == "deposits") return {list_of(world.deposits(), "deposits"), {}};
  if (what == "collisions") return {list_of(world.collisions(), "collisions"), {}};
  if (what == "write_deposits") return {done(world.write_deposits(q.at("path").get<std::string>())), {}};
  if (what == "placement") return {value(world.placement()), {}};
  if (what == "script_left") {
    const bool ends = q.value("machine_ends", false);
    return {value(world.script_left(ends ? WorldAccess::Machine::Ends : WorldAccess::Machine::GoesOn)), {}};
  }
  if (what == "add_script") return {done(world.add_script(q.at("yaml").get<std::string>())), {}};
  return {refused({Fault::Usage, fmt::format("the world cannot '{}'", what), {}}), {}};
}

/// One line; what is no UTF-8 (a question that is quoted back) is replaced.
std::string text_of(const json& line) { return line.dump(-1, ' ', false, json::error_handler_t::replace); }

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  return address;
}

/// Nothing, or a dead socket, may stand at the path.
Result<void> clear_path(const std::string& path) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0) return {};
  if (!S_ISSOCK(there.st_mode))
    return fail(Fault::FileUnwritable, "something that is no socket stands there; choose another path", path);
  const LineSocket probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const sockaddr_un address = address_of(path);
  if (::connect(probe.fd(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
    return fail(Fault::SecondOwner, "another simulated machine answers on this socket; stop it or choose another path",
                path);
  ::unlink(path.c_str());
  return {};
}

}  // namespace

Result<std::unique_ptr<WorldServer>> WorldServer::listen(SimulatedMachine& world, const std::string& path) {
  if (path.size() >= sizeof(sockaddr_un::sun_path))
    return fail(Fault::Usage, fmt::format("a socket's path has at most {} bytes", sizeof(sockaddr_un::sun_path) - 1),
                path);
  if (auto clear = clear_path(path); !clear) return tl::unexpected(clear.error());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const sockaddr_un address = address_of(path);
  // The mode of the socket's inode before bind() is what the file gets (Linux, unix_mknod).
  if (fd < 0 || ::fchmod(fd, 0600) != 0 ||
      ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(fd, 8) != 0) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) ::close(fd);
    return fail(Fault::FileUnwritable, fmt::format("cannot listen there: {}", why), path);
  }
  return std::unique_ptr<WorldServer>(new WorldServer(world, path, fd));
}

WorldServer::WorldServer(SimulatedMachine& world, std::string path, int listening)
    : world_(world), path_(std::move(path)), listening_(listening), acceptor_([this] { accept_clients(); }) {}

WorldServer::~WorldServer() {
  stop_ = true;
  acceptor_.join();
  for (Client& c : clients_) {
    ::shutdown(c.socket.fd(), SHUT_RDWR);
    c.thread.join();
  }
  ::close(listening_);
  ::unlink(path_.c_str());
}

void WorldServer::accept_clients() {
  while (!stop_) {
    pollfd p{listening_, POLLIN, 0};
    constexpr int kLook_ms = 50;
    if (::poll(&p, 1, kLook_ms) <= 0) continue;
    const int fd = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
    if (fd < 0) continue;
    Client& client = clients_.emplace_back(fd);
    client.thread = std::thread([this, &client] {
      converse(client.socket);
      client.gone = true;
    });
    forget_gone_clients();
  }
}

void WorldServer::forget_gone_clients() {
  for (auto c = clients_.begin(); c != clients_.end();) {
    if (!c->gone) {
      ++c;
      continue;
    }
    c->thread.join();
    c = clients_.erase(c);
  }
}

void WorldServer::converse(LineSocket& client) {
  while (const auto line = client.read_line()) {
    Answer a;
    try {
      a = answer(world_, json::parse(*line));
    } catch (const json::exception& e) {
      a.line = refused({Fault::BadValue, fmt::format("the question is not understood: {}", e.what()), {}});
    }
    if (!client.write(text_of(a.line) + "\n") || !client.write(a.pixels)) return;
  }
}

}  // namespace gantry::sim
