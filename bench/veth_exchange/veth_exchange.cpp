// One side of the comparison that run.sh makes:
//   veth_exchange ours  --interface IF --machine FILE --cycles N     our master's exchange(), once a millisecond
//   veth_exchange plain --interface IF --size BYTES --cycles N       a frame of that size out and back by send and recv
//   veth_exchange echo  --interface IF                               the far end of `plain`
// Prints "median M p99 P lost L size S" in microseconds. Every wait blocks; nothing spins.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <arpa/inet.h>
#include <atomic>
#include <fmt/format.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <thread>
#include <vector>

#include "config/machine.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/passing_port.hpp"
#include "devices/raw_socket_port.hpp"

using namespace gantry;
using namespace gantry::devices;

namespace {

constexpr int kMasterPriority = 80, kFarPriority = 50;  // `gantry sim` gives itself the same as the echo
constexpr Time kPeriod = milliseconds(1);
constexpr int kWarmUp = 200;
constexpr std::uint16_t kEtherCat = 0x88A4;

void real_time(int priority) {
  sched_param p{};
  p.sched_priority = priority;
  if (::sched_setscheduler(0, SCHED_FIFO, &p) != 0) fmt::print(stderr, "no real-time priority\n");
  ::mlockall(MCL_CURRENT | MCL_FUTURE);
}

int open_socket(const std::string& interface) {
  const int fd = ::socket(AF_PACKET, SOCK_RAW, htons(kEtherCat));
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(kEtherCat);
  address.sll_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  const int on = 1;
  const timeval patience{.tv_sec = 0, .tv_usec = 20'000};
  if (fd < 0 || ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::setsockopt(fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on) != 0 ||
      ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0) {
    fmt::print(stderr, "{}: no raw socket\n", interface);
    std::exit(1);
  }
  return fd;
}

struct Turns {
  std::vector<double> us;
  int lost = 0;
  void print(std::size_t size) {
    if (us.empty()) us.push_back(0);
    std::sort(us.begin(), us.end());
    fmt::print("median {:.1f} p99 {:.1f} lost {} size {}\n", us[us.size() / 2], us[us.size() * 99 / 100], lost, size);
  }
};

/// Calls `exchange` once a period, with the instant at which it is due, and keeps how long each took; false from it:
/// lost, which counts with the time that was waited. `rest` is called when that is over, with the next instant: what a
/// cycle has to do for the one after it.
template <class F, class R>
Turns beat(int cycles, Clock& clock, F exchange, R rest) {
  Turns turns;
  turns.us.reserve(static_cast<std::size_t>(cycles));
  Time next = clock.now() + kPeriod;
  for (int n = 0; n < cycles + kWarmUp; ++n) {
    clock.sleep_until(next);
    const Time begin = clock.now();
    const bool back = exchange(next);
    const Time end = clock.now();
    if (n >= kWarmUp) turns.us.push_back(static_cast<double>((end - begin).count()) / 1000);
    if (n >= kWarmUp && !back) ++turns.lost;
    next = std::max(next + kPeriod, end);
    rest(next);
  }
  return turns;
}

int plain(const std::string& interface, std::size_t size, int cycles) {
  real_time(kMasterPriority);
  const int fd = open_socket(interface);
  std::vector<std::uint8_t> frame(size), back(2048);
  std::fill_n(frame.begin(), 6, std::uint8_t{0xFF});
  frame[12] = kEtherCat >> 8, frame[13] = kEtherCat & 0xFF;
  MonotonicClock clock;
  beat(
      cycles, clock,
      [&](Time) {
        return ::send(fd, frame.data(), frame.size(), 0) == static_cast<ssize_t>(size) &&
               ::recv(fd, back.data(), back.size(), 0) == static_cast<ssize_t>(size);
      },
      [](Time) {})
      .print(size);
  return 0;
}

int echo(const std::string& interface) {
  real_time(kFarPriority);
  const int fd = open_socket(interface);
  std::vector<std::uint8_t> frame(2048);
  for (;;)
    if (const ssize_t got = ::recv(fd, frame.data(), frame.size(), 0); got > 0)
      ::send(fd, frame.data(), static_cast<std::size_t>(got), 0);
}

/// Tells how long the cyclic frame is.
class SizedPort final : public PassingPort {
 public:
  explicit SizedPort(FramePort& port) : PassingPort(port) {}
  std::size_t last = 0;
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override {
    last = frame.size();
    return port_.send(port, frame);
  }
};

int ours(const config::Machine& machine, const std::string& interface, int cycles, Time wait) {
  MonotonicClock clock;
  auto wire = RawSocketPort::open(interface);
  if (!wire) return fmt::print(stderr, "{}\n", to_text(wire.error())), 1;
  SizedPort port(**wire);
  EthercatMaster master(machine, port, clock);
  if (auto up = master.bring_up(); !up) return fmt::print(stderr, "{}\n", to_text(up.error())), 1;
  // Blocking requests ride in the cycle's frames, so the cycle has a thread of its own.
  std::atomic<bool> operating{false};
  std::atomic<int> states{0};
  std::thread loop([&] {
    real_time(kMasterPriority);
    const auto exchange = [&](Time due) {
      const Exchange e = master.exchange(due + wait);
      states = e.ethercat.al_states;
      return e.inputs_fresh;
    };
    const auto rest = [&](Time next) { master.arm(next + wait); };  // as the loop of a machine
    while (!operating) beat(1, clock, exchange, rest);
    beat(cycles, clock, exchange, rest).print(port.last);
  });
  const auto asked = master.request_operation();
  if (!asked) fmt::print(stderr, "{}\n", to_text(asked.error()));
  for (int i = 0; i < 500 && asked && states != 8; ++i) clock.sleep_until(clock.now() + milliseconds(10));
  const auto all_there = master.check_operation();
  if (!all_there) fmt::print(stderr, "{}\n", to_text(all_there.error()));
  operating = true;
  loop.join();
  master.shut_down();
  return all_there ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Round trips over a veth pair; see run.sh"};
  std::string what, interface, machine_file = "config/machines/dispenser.yaml";
  std::size_t size = 300;
  int cycles = 3000, wait_us = 400;
  app.add_option("WHAT", what, "ours, plain or echo")->required()->check(CLI::IsMember({"ours", "plain", "echo"}));
  app.add_option("--interface", interface, "Network interface")->required();
  app.add_option("--machine", machine_file, "Machine file");
  app.add_option("--size", size, "Bytes of the plain frame")->check(CLI::Range(60, 1514));
  app.add_option("--cycles", cycles, "Cycles that count");
  app.add_option("--wait", wait_us, "How long our master waits for its frame, in us; the loop of a machine: 400");
  CLI11_PARSE(app, argc, argv);
  if (what == "plain") return plain(interface, size, cycles);
  if (what == "echo") return echo(interface);
  const auto machine = config::load_machine(machine_file);
  if (!machine) return fmt::print(stderr, "{}\n", to_text(machine.error().front())), 1;
  return ours(*machine, interface, cycles, microseconds(wait_us));
}
