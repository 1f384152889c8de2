// How late does our 1 ms loop wake up, next to cyclictest on the same machine at the same time?
//   sudo build/release/bin/wake_up --pairs 6 --seconds 20
// A pair is two runs: ours on CPU a with cyclictest on CPU b, then swapped, so that a noisy CPU serves both. Single
// pairs lie by chance; the geometric mean over several is what counts. The maximum is told and never judged: on a
// virtual machine it is the host's.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <thread>
#include <vector>

#include "bench/wake_up/cyclictest.hpp"
#include "core/clock.hpp"

namespace gantry::bench {
namespace {

/// Our loop at its least: absolute sleeps on the monotonic clock, nothing to do when awake. Fault::RealTimeRefused.
Result<Latencies> run_loop(const Plan& plan) {
  std::vector<std::int64_t> late_ns(
      static_cast<std::size_t>(plan.cycles));  // touched here, so that no page is new later
  int refused = 0;
  std::thread thread([&] {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(static_cast<std::size_t>(plan.cpu), &cpus);
    const sched_param fifo{.sched_priority = plan.priority};
    refused = pthread_setaffinity_np(pthread_self(), sizeof cpus, &cpus);
    if (refused == 0) refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo);
    if (refused != 0) return;
    MonotonicClock clock;
    Time next = clock.now() + milliseconds(1);
    for (std::int64_t& late : late_ns) {
      clock.sleep_until(next);
      const Time now = clock.now();
      late = (now - next).count();
      do
        next += milliseconds(1);  // after a stall the phase is kept and nothing comes in a burst, as cyclictest does it
      while (next <= now);
    }
  });
  thread.join();
  if (refused != 0)
    return fail(Fault::RealTimeRefused, std::string("the loop's thread was refused SCHED_FIFO or its CPU: ") +
                                            std::strerror(refused) + "; run as root, or see `gantry doctor`");
  Latencies latencies;
  for (const std::int64_t ns : late_ns) latencies.add(ns / 1000);
  return latencies;
}

struct Run {
  Latencies ours, theirs;
};

Result<Run> run_beside(const Plan& ours, const Plan& theirs) {
  auto peer = Cyclictest::start(theirs);
  if (!peer) return tl::unexpected(peer.error());
  auto own = run_loop(ours);
  auto measured = peer->finish();
  if (!own) return tl::unexpected(own.error());
  if (!measured) return tl::unexpected(measured.error());
  return Run{*own, *measured};
}

void print(const char* who, int cpu, const Latencies& l) {
  std::printf("  %-11s CPU %d  %6ld %6ld %6ld %7ld   %7lu\n", who, cpu, l.quantile(kQuantiles[0]),
              l.quantile(kQuantiles[1]), l.quantile(kQuantiles[2]), l.max(), l.above(1000));
}

int measure(int pairs, int seconds, int priority, const std::vector<int>& cpus) {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) std::printf("memory could not be locked: %s\n", std::strerror(errno));
  const int cycles = seconds * 1000;
  std::array<double, kQuantiles.size()> log_ratio{};
  std::uint64_t late_ours = 0, late_theirs = 0, runs = 0;
  std::printf("1 ms, SCHED_FIFO %d, %d s a run; us: p50, p99, p99.9, max; wake-ups later than 1 ms\n", priority,
              seconds);
  for (int pair = 1; pair <= pairs; ++pair) {
    std::printf("pair %d\n", pair);
    for (const int swap : {0, 1}) {
      const Plan ours{cpus[static_cast<std::size_t>(swap)], priority, cycles};
      const Plan theirs{cpus[static_cast<std::size_t>(1 - swap)], priority, cycles};
      const auto run = run_beside(ours, theirs);
      if (!run) {
        std::fprintf(stderr, "%s\n", to_text(run.error()).c_str());
        return static_cast<int>(info(run.error().fault).exit_code);
      }
      print("ours", ours.cpu, run->ours);
      print("cyclictest", theirs.cpu, run->theirs);
      for (std::size_t q = 0; q < kQuantiles.size(); ++q)  // half a microsecond: the resolution, and never a zero
        log_ratio[q] += std::log((static_cast<double>(run->ours.quantile(kQuantiles[q])) + 0.5) /
                                 (static_cast<double>(run->theirs.quantile(kQuantiles[q])) + 0.5));
      late_ours += run->ours.above(1000);
      late_theirs += run->theirs.above(1000);
      ++runs;
    }
    std::fflush(stdout);
  }
  std::printf("ratio ours / cyclictest, geometric mean of %d swapped pairs:", pairs);
  for (std::size_t q = 0; q < kQuantiles.size(); ++q)
    std::printf("  p%g %.2f", 100 * kQuantiles[q], std::exp(log_ratio[q] / static_cast<double>(runs)));
  std::printf("\nlater than 1 ms: ours %lu, cyclictest %lu of %lu each\n", late_ours, late_theirs,
              runs * static_cast<std::uint64_t>(cycles));
  return 0;
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  CLI::App app{"Wake-up latency of a 1 ms loop next to cyclictest, on swapped CPUs"};
  int pairs = 4, seconds = 15, priority = 90;
  std::vector<int> cpus{0, 1};
  app.add_option("--pairs", pairs, "swapped pairs of runs")->check(CLI::Range(1, 1000));
  app.add_option("--seconds", seconds, "length of a run")->check(CLI::Range(1, 3600));
  app.add_option("--priority", priority, "of SCHED_FIFO")->check(CLI::Range(1, 99));
  app.add_option("--cpus", cpus, "the two CPUs")->expected(2);
  CLI11_PARSE(app, argc, argv);
  return gantry::bench::measure(pairs, seconds, priority, cpus);
}
