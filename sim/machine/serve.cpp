#include "sim/machine/serve.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <poll.h>
#include <pthread.h>
#include <string>
#include <thread>
#include <unistd.h>

#include "core/log.hpp"
#include "devices/raw_socket_port.hpp"
#include "sim/machine/world_server.hpp"
#include "sim/segment/delay_line.hpp"

namespace gantry::sim {

namespace {

/// Answers frames like a ring of stations until `stop`; time passes for the stations without frames too, so that their
/// watchdogs notice a master that is gone. What is too long for a frame, or no EtherCAT, goes by unanswered.
void answer_frames(devices::FramePort& wire, VirtualMachine& world, const Clock& clock, const std::atomic<bool>& stop) {
  // Longer than a master's cycle: a wait that runs out just when the next frame is due would delay that frame.
  constexpr Time kPatience = milliseconds(5);
  std::array<std::byte, 2 * devices::kMaxFrameBytes> buffer;  // an oversize frame must not look like a whole one
  const auto late = std::make_unique<DelayLine>();            // what a script holds back
  while (!stop) {
    const auto got = wire.receive(buffer, std::min(clock.now() + kPatience, late->next()));
    if (got.size > 0 && got.size <= devices::kMaxFrameBytes) {
      const std::span frame(buffer.data(), got.size);
      if (world.answer(frame)) {
        const FrameFate& fate = world.fate();
        const bool at_once = !fate.held && !fate.duplicate && fate.delay == Time{0} && late->empty();
        if (at_once)
          wire.send(got.port, frame);
        else
          late->put(frame, clock.now(), fate);
      }
    } else if (got.size == 0) {
      world.pass_time();
    }
    for (; late->next() <= clock.now(); late->pop()) wire.send(devices::PortIndex::Primary, late->front());
  }
}

/// Script entries, one a line, until stdin ends or `stop`.
void read_script_lines(VirtualMachine& world, const std::atomic<bool>& stop) {
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
  auto world = VirtualMachine::open(machine, clock, options.world);
  if (!world) return tl::unexpected(world.error());
  std::unique_ptr<WorldServer> server;
  if (!options.world_socket.empty()) {
    auto listening = WorldServer::listen(**world, options.world_socket);
    if (!listening) return tl::unexpected(listening.error());
    server = std::move(*listening);
  }
  std::thread script;
  if (options.script_on_stdin) script = std::thread([&] { read_script_lines(**world, stop); });
  std::thread bus([&] {
    ask_for_priority();
    answer_frames(**wire, **world, clock, stop);
  });
  bus.join();
  if (script.joinable()) script.join();
  return {};
}

}  // namespace gantry::sim
