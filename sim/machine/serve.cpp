#include "sim/machine/serve.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <mutex>
#include <poll.h>
#include <pthread.h>
#include <string>
#include <sys/mman.h>
#include <thread>
#include <unistd.h>

#include "core/log.hpp"
#include "devices/raw_socket_port.hpp"
#include "sim/machine/world_server.hpp"
#include "sim/segment/delay_line.hpp"
#include "sim/world/priority_mutex.hpp"

namespace gantry::sim {

namespace {

/// The simulated machine between the thread that answers frames and the one that lets time pass.
struct Shared {
  SimulatedMachine& world;
  Clock& clock;
  const std::atomic<bool>& stop;
  PriorityMutex mutex;
};

/// Answers frames like a ring of stations. What is too long for a frame, or no EtherCAT, goes by unanswered.
void answer_frames(devices::FramePort& wire, Shared& shared) {
  constexpr Time kLook = milliseconds(100);                   // for `stop`
  std::array<std::byte, 2 * devices::kMaxFrameBytes> buffer;  // an oversize frame must not look like a whole one
  const auto late = std::make_unique<DelayLine>();            // what a script holds back, or sets behind
  while (!shared.stop) {
    const auto got = wire.receive(buffer, std::min(shared.clock.now() + kLook, late->next()));
    if (got.size > 0 && got.size <= devices::kMaxFrameBytes) {
      const std::span frame(buffer.data(), got.size);
      std::unique_lock lock(shared.mutex);
      const bool back = shared.world.answer(frame);
      const FrameFate fate = shared.world.fate();
      lock.unlock();
      const bool at_once = !fate.held && !fate.duplicate && !fate.foreign && fate.delay == Time{0} && late->empty();
      if (back && at_once)
        wire.send(got.port, frame);
      else if (back)
        late->put(frame, shared.clock.now(), fate);
    }
    for (; late->next() <= shared.clock.now(); late->pop()) wire.send(devices::PortIndex::Primary, late->front());
  }
}

/// Cycles of the stations happen when they are due, and not only when the next frame asks for them: that frame finds
/// them done, and the stations' watchdogs notice a master that is gone.
void let_time_pass(Shared& shared) {
  constexpr Time kPatience = milliseconds(5);  // a frame may have brought the next one nearer
  while (!shared.stop) {
    std::unique_lock lock(shared.mutex);
    shared.world.pass_time();
    const Time next = shared.world.next_tick();
    lock.unlock();
    shared.clock.sleep_until(std::min(shared.clock.now() + kPatience, next));
  }
}

/// Script entries, one a line, until stdin ends or `stop`.
void read_script_lines(SimulatedMachine& world, const std::atomic<bool>& stop) {
  std::string text;
  while (!stop) {
    pollfd p{STDIN_FILENO, POLLIN, 0};
    constexpr int kLook_ms = 50;
    if (::poll(&p, 1, kLook_ms) <= 0) continue;
    char chunk[4096];
    const ssize_t n = ::read(STDIN_FILENO, chunk, sizeof chunk);
    if (n <= 0) return;
    text.append(chunk, static_cast<std::size_t>(n));
    for (std::size_t end = 0; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1))
      if (const auto line = text.substr(0, end); line.find_first_not_of(" \t\r") != std::string::npos)
        if (auto added = world.add_script(line); !added) log::report(added.error());
  }
}

/// Where it is allowed: a page that the system took back would cost a master its cycle.
void keep_memory() {
  if (::mlockall(MCL_CURRENT) != 0)
    log::info("the virtual bus answers from memory that the system may take back ({})", std::strerror(errno));
}

/// Real time where it is allowed: a master's cycle does not wait for us.
void ask_for_priority() {
  sched_param p{};
  p.sched_priority = 50;
  if (const int problem = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &p); problem != 0)
    log::info("the virtual bus answers without real-time priority ({})", std::strerror(problem));
}

}  // namespace

Result<void> serve(const config::Machine& machine, const ServeOptions& options, const std::atomic<bool>& stop) {
  auto wire = devices::RawSocketPort::open(options.interface);
  if (!wire) return tl::unexpected(wire.error());
  MonotonicClock clock;
  auto world = SimulatedMachine::open(machine, clock, options.world);
  if (!world) return tl::unexpected(world.error());
  std::unique_ptr<WorldServer> server;
  if (!options.world_socket.empty()) {
    auto listening = WorldServer::listen(**world, options.world_socket);
    if (!listening) return tl::unexpected(listening.error());
    server = std::move(*listening);
  }
  std::thread script;
  if (options.script_on_stdin) script = std::thread([&] { read_script_lines(**world, stop); });
  Shared shared{**world, clock, stop, {}};
  std::thread time([&] {
    ask_for_priority();
    let_time_pass(shared);
  });
  std::thread bus([&] {
    ask_for_priority();
    keep_memory();
    answer_frames(**wire, shared);
  });
  bus.join();
  time.join();
  if (script.joinable()) script.join();
  return {};
}

}  // namespace gantry::sim
