// How soon the stop frame is out: after the last beat of a loop that stops beating (limit 4 ms, that of hardware), and
// after a signal that ends the program; and what it costs to have it ready in every cycle of the reference machine.
//   build/release/bin/bench_last_word [N]          (in the source folder: it reads the shipped machine)
// The frame goes to a local socket, and its arrival is seen by a thread (SCHED_FIFO 70) that has to wake up first.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <vector>

#include "app/cycle/crash_stop.hpp"
#include "app/cycle/watchdog.hpp"
#include "app/run/compose.hpp"
#include "devices/ethercat/master.hpp"
#include "sim/segment/segment.hpp"
#include "sim/segment/segment_port.hpp"
#include "tests/app/cycle/one_drive.hpp"

namespace gantry::bench {
namespace {

void show(const char* what, std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  const auto at = [&](double q) { return ms[static_cast<std::size_t>(q * static_cast<double>(ms.size() - 1))]; };
  std::printf("%-46s p50 %7.3f  p99 %7.3f  max %7.3f ms   (%zu)\n", what, at(0.5), at(0.99), at(1), ms.size());
}

void beats_that_stop(int times) {
  test::OneDrive drive;
  MonotonicClock clock;
  std::mt19937 random(1);
  std::vector<double> ms;
  cycle::Watchdog dog(drive.stop, clock, milliseconds(4));
  for (int n = 0; n < times; ++n) {
    const int beats = std::uniform_int_distribution(2, 20)(random);
    for (int i = 0; i < beats; ++i) {
      if (i > 0) clock.sleep_until(clock.now() + microseconds(std::uniform_int_distribution(900, 1100)(random)));
      drive.beat(clock.now());
    }
    drive.wire.read(1000);
    ms.push_back(1e3 * seconds(clock.now() - drive.stop.last_beat()));
    while (!drive.wire.read(0).empty()) {  // a beat of this thread itself may have been late
    }
  }
  show("last beat -> stop frame (limit 4 ms)", ms);
}

void signals(int times) {
  MonotonicClock clock;
  std::vector<double> ms;
  for (int n = 0; n < times; ++n) {
    test::OneDrive drive;
    drive.beat(clock.now());
    test::TwoEnds ready;
    const pid_t child = fork();
    if (child == 0) {
      const rlimit no_core{0, 0};
      setrlimit(RLIMIT_CORE, &no_core);
      const cycle::CrashStop armed(drive.stop);
      ::send(ready.in(), "x", 1, 0);
      for (;;) pause();
    }
    ready.read(10'000);
    const Time sent = clock.now();
    kill(child, SIGSEGV);
    drive.wire.read(1000);
    ms.push_back(1e3 * seconds(clock.now() - sent));
    waitpid(child, nullptr, 0);
  }
  show("SIGSEGV -> stop frame", ms);
}

void cost() {
  const config::Machine machine = config::load_machine("config/machines/dispenser.yaml").value();
  const auto setup = run::compose_loop(machine, run::Host::Hardware).value();
  VirtualClock clock;
  sim::Segment segment(machine, clock);
  sim::SegmentPort port(segment, clock);
  devices::EthercatMaster master(machine, port, clock);
  if (auto up = master.bring_up(); !up) return void(std::printf("%s\n", to_text(up.error()).c_str()));
  cycle::StopFrame stop(setup, -1);
  constexpr int kCycles = 200'000;
  double best_ns = 1e9;
  for (int round = 0; round < 5; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < kCycles; ++i) {
      stop.make(master);
      stop.begin_exchange(Time{i});
      stop.end_exchange();
    }
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
    best_ns = std::min(best_ns, took.count() / kCycles);
  }
  std::printf("%-46s %.0f ns a cycle (best of 5 x %d)\n", "keeping it ready, reference machine", best_ns, kCycles);
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  const int times = argc > 1 ? std::atoi(argv[1]) : 500;
  mlockall(MCL_CURRENT | MCL_FUTURE);
  sched_param below_the_loop{};
  below_the_loop.sched_priority = 70;
  if (sched_setscheduler(0, SCHED_FIFO, &below_the_loop) != 0) std::printf("without real-time priority\n");
  gantry::bench::beats_that_stop(times);
  gantry::bench::signals(times);
  gantry::bench::cost();
}
