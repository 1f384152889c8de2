// How late does our 1 ms loop wake up, next to cyclictest on the same machine at the same time?
//   sudo build/release/bin/wake_up                                   a loop with nothing in it
//   sudo build/release/bin/wake_up --job recipes/demo-board.yaml     the program, with every axis of the machine
// A pair is two runs: ours on CPU a with cyclictest on CPU b, then swapped, so that a noisy CPU serves both. Single
// pairs lie by chance; the geometric mean over several is what counts. The maximum is told and never judged: on a
// virtual machine it is the host's.
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <sys/mman.h>
#include <vector>

#include "bench/wake_up/cyclictest.hpp"
#include "bench/wake_up/subject.hpp"

namespace gantry::bench {
namespace {

struct Options {
  int pairs = 4, seconds = 15, priority = 90;
  std::vector<int> cpus{0, 1};
  std::string job, program;
};

struct Run {
  Figures ours, theirs;
};

Result<Run> run_beside(const Options& options, int our_cpu, int their_cpu) {
  auto peer = Cyclictest::start(their_cpu, options.priority);
  if (!peer) return tl::unexpected(peer.error());
  auto own = options.job.empty() ? run_empty_loop(our_cpu, options.priority, options.seconds)
                                 : run_job(our_cpu, options.program, options.job);
  if (!own) return tl::unexpected(own.error());
  const auto measured = peer->finish();
  if (!measured) return tl::unexpected(measured.error());
  return Run{*own, figures(*measured)};
}

void print(const char* who, int cpu, const Figures& f) {
  std::printf("  %-10s CPU %d %8.1f %8.1f %8.1f %9.1f %6lu %6lu %6lu of %-7lu %s\n", who, cpu, f.at[0], f.at[1],
              f.at[2], f.max, f.stalls, f.slept, f.missed, f.cycles, f.cost.c_str());
}

void add(Figures& sum, const Figures& run) {
  sum.stalls += run.stalls, sum.slept += run.slept, sum.missed += run.missed, sum.cycles += run.cycles;
}

double share(std::uint64_t of, const Figures& f) {
  return f.cycles > 0 ? static_cast<double>(of) / static_cast<double>(f.cycles) : 0;
}

Result<void> measure(const Options& options) {
  std::array<double, kQuantiles.size()> log_ratio{};
  Figures ours, theirs;
  std::printf(
      "1 ms, SCHED_FIFO; wake-up in us: p50, p99, p99.9, max; stalls (wake-ups more than a period late); periods slept "
      "through; deadlines missed of all; cost of a cycle p50 / p99 / p99.9 / max in us\n");
  for (int pair = 1; pair <= options.pairs; ++pair) {
    std::printf("pair %d\n", pair);
    for (const std::size_t swap : {0u, 1u}) {
      const int our_cpu = options.cpus[swap], their_cpu = options.cpus[1 - swap];
      const auto run = run_beside(options, our_cpu, their_cpu);
      if (!run) return tl::unexpected(run.error());
      print("ours", our_cpu, run->ours);
      print("cyclictest", their_cpu, run->theirs);
      for (std::size_t q = 0; q < kQuantiles.size(); ++q)  // half a microsecond: the resolution, and never a zero
        log_ratio[q] += std::log((run->ours.at[q] + 0.5) / (run->theirs.at[q] + 0.5));
      add(ours, run->ours);
      add(theirs, run->theirs);
      std::fflush(stdout);
    }
  }
  std::printf("ratio ours / cyclictest, geometric mean of %d swapped pairs:", options.pairs);
  for (std::size_t q = 0; q < kQuantiles.size(); ++q)
    std::printf("  p%g %.2f", 100 * kQuantiles[q], std::exp(log_ratio[q] / (2.0 * options.pairs)));
  std::printf("\nstalls: ours %lu, cyclictest %lu\n", ours.stalls, theirs.stalls);
  std::printf("periods slept through: ours %lu of %lu (%.2e), cyclictest %lu of %lu (%.2e)\n", ours.slept, ours.cycles,
              share(ours.slept, ours), theirs.slept, theirs.cycles, share(theirs.slept, theirs));
  std::printf("with cycles that were not done in time (cyclictest has no work): ours %lu (%.2e)\n", ours.missed,
              share(ours.missed, ours));
  return {};
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  namespace bench = gantry::bench;
  CLI::App app{"Wake-up latency of a 1 ms loop next to cyclictest, on swapped CPUs"};
  bench::Options options;
  options.program = (std::filesystem::canonical("/proc/self/exe").parent_path() / "gantry").string();
  app.add_option("--pairs", options.pairs, "swapped pairs of runs")->check(CLI::Range(1, 1000));
  app.add_option("--seconds", options.seconds, "length of a run of the empty loop")->check(CLI::Range(1, 3600));
  app.add_option("--priority", options.priority, "of SCHED_FIFO, for cyclictest and the empty loop")
      ->check(CLI::Range(1, 99));
  app.add_option("--cpus", options.cpus, "the two CPUs")->expected(2);
  app.add_option("--job", options.job, "recipe to run with the program instead of the empty loop");
  app.add_option("--program", options.program, "the program that runs it");
  CLI11_PARSE(app, argc, argv);
  if (options.job.empty() && mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    std::printf("memory could not be locked: %s\n", std::strerror(errno));
  const auto done = bench::measure(options);
  if (done) return 0;
  std::fprintf(stderr, "%s\n", gantry::to_text(done.error()).c_str());
  return static_cast<int>(gantry::info(done.error().fault).exit_code);
}
