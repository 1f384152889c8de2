// Beads and moves with holds, resumes, overrides and aborts at random instants: limits, path and stops of each.
//   play_campaign --cases 10000 --seed 1
// Ends with 0 when nothing was wrong.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "tests/motion/rt/trial.hpp"

int main(int argc, char** argv) {
  std::uint64_t cases = 1000, seed = 1;
  CLI::App app{"disturbs motion at random instants and judges its setpoints"};
  app.add_option("--cases", cases);
  app.add_option("--seed", seed, "of the first case; the others follow");
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  gantry::motion::test::Verdict all;
  std::uint64_t failed = 0;
  for (std::uint64_t n = seed; n < seed + cases; ++n) {
    const auto v = gantry::motion::test::trial(n);
    all.v = std::max(all.v, v.v), all.a = std::max(all.a, v.a), all.j = std::max(all.j, v.j);
    all.off_mm = std::max(all.off_mm, v.off_mm);
    all.stop_share = std::max(all.stop_share, v.stop_share), all.stop_s = std::max(all.stop_s, v.stop_s);
    all.worst_tick_us = std::max(all.worst_tick_us, v.worst_tick_us);
    all.stops += v.stops, all.line_stops += v.line_stops, all.changes += v.changes, all.ticks += v.ticks;
    if (!v.wrong.empty() && ++failed <= 40) std::printf("seed %lu: %s\n", n, v.wrong.c_str());
  }
  std::printf(
      "%lu blocks, %zu ticks, %zu stops (%zu on lines, longest %.4f of the ideal), %zu other changes; longest stop "
      "%.3f s; "
      "%.2g um off the path; limits: v %.4f a %.4f j %.4f; longest tick %.0f us; %lu failed\n",
      cases, all.ticks, all.stops, all.line_stops, all.stop_share, all.changes, all.stop_s, 1e3 * all.off_mm, all.v,
      all.a, all.j, all.worst_tick_us, failed);
  return failed == 0 ? 0 : 1;
}
