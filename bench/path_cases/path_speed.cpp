// How long planning a path and playing it takes, as JSON on stdout:
//   path_speed [--points 1000000]
// {add_us: {median, p99, max}, setpoint_us: {median, p99, max}, growth: [{points, plan_s, us_per_point, rss_mb}]}
// add: each point of a path of short chords with bends and corners, one call of add() and all of take(). setpoint: each
// tick of the loop's interpolator on a bead of that shape. growth: the same path 10^4 points long and longer, planned
// and thrown away; rss_mb is the most memory that the program then had beyond what it had before.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

#include "motion/path/bead.hpp"
#include "motion/path/path_planner.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::bench {
namespace {

using Clock = std::chrono::steady_clock;

double us_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

motion::Limits limits() {
  motion::Limits l;
  l.axes = 3;
  l.tick_s = 0.001;
  for (std::size_t i = 0; i < l.axes; ++i) l.axis[i] = {-1e9, 1e9, 200, 3000, 50000}, l.linear[i] = true;
  return l;
}

/// The n-th point of an endless wave in chords of half a mm, with a corner every 100 of them.
AxisVec point(std::size_t n) {
  const double x = 0.5 * static_cast<double>(n);
  return {x, 6 * std::sin(x / 14) + ((n / 100) % 2 == 0 ? 0.0 : 1.5), 0.2 * std::sin(x / 90)};
}

struct Times {
  double median = 0, p99 = 0, max = 0;
};
Times times_of(std::vector<double> us) {
  std::sort(us.begin(), us.end());
  const auto at = [&](double q) { return us[static_cast<std::size_t>(q * static_cast<double>(us.size() - 1))]; };
  return {at(0.5), at(0.99), us.back()};
}

/// Pages that the program has in memory now, in MB.
double resident_mb() {
  std::ifstream in("/proc/self/statm");
  std::size_t whole = 0, resident = 0;
  in >> whole >> resident;
  return static_cast<double>(resident) * 4096 / 1e6;
}

struct Growth {
  std::size_t points = 0;
  double plan_s = 0, rss_mb = 0;
};

/// Plans so many points; what each call took goes into `us`, if it is not null.
Growth plan(std::size_t points, std::vector<double>* us) {
  constexpr std::size_t kLook = 500;
  const double before_mb = resident_mb();
  Growth out{points, 0, 0};
  motion::PathPlanner planner(limits(), {.tolerance_mm = 0.05, .speed_mm_s = 400});
  motion::Stretch stretch;
  const auto begin = Clock::now();
  for (std::size_t n = 0; n < points; ++n) {
    const AxisVec p = point(n);
    const auto call = Clock::now();
    if (const auto ok = planner.add(p); !ok) std::fprintf(stderr, "%s\n", ok.error().message.c_str());
    while (planner.take(stretch)) {
    }
    if (us != nullptr) us->push_back(us_since(call));
    if (n % kLook == 0) out.rss_mb = std::max(out.rss_mb, resident_mb() - before_mb);
  }
  if (const auto ok = planner.finish(); !ok) std::fprintf(stderr, "%s\n", ok.error().message.c_str());
  while (planner.take(stretch)) {
  }
  out.plan_s = us_since(begin) * 1e-6;
  return out;
}

/// Every tick of beads along that path.
std::vector<double> setpoints() {
  constexpr std::size_t kPoints = 1000, kBeads = 10;
  std::vector<double> us;
  for (std::size_t k = 0; k < kBeads; ++k) {
    motion::BeadSpec spec;
    for (std::size_t n = 0; n < kPoints; ++n) spec.points.push_back(point(k * kPoints + n));
    spec.speed_mm_s = 150, spec.corner_tolerance_mm = 0.05, spec.valve = 1, spec.block = 1;
    spec.open_lead_s = 0.008, spec.close_lead_s = 0.006;
    auto bead = motion::plan_bead(limits(), spec);
    if (!bead) continue;
    bead->segments.back().ends_block = true;
    const auto ring = std::make_unique<motion::SegmentRing>();
    const auto play = std::make_unique<motion::Interpolator>(*ring, limits(), 1);
    play->start(bead->start);
    play->begin_block(1);
    for (std::size_t next = 0; !play->idle();) {
      while (next < bead->segments.size() && ring->push(bead->segments[next])) ++next;
      const auto call = Clock::now();
      const motion::Setpoint p = play->step(1);
      us.push_back(us_since(call));
      if (p.block_done) break;
    }
  }
  return us;
}

void print(const char* name, const Times& t) {
  std::printf("\"%s\": {\"median\": %.3f, \"p99\": %.3f, \"max\": %.1f}, ", name, t.median, t.p99, t.max);
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  using namespace gantry::bench;
  std::size_t most = 1'000'000;
  CLI::App app{"how long planning a path and playing it takes"};
  app.add_option("--points", most, "the longest path that is planned")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  std::vector<double> us;
  plan(20'000, &us);
  std::printf("{");
  print("add_us", times_of(us));
  print("setpoint_us", times_of(setpoints()));
  std::printf("\"growth\": [");
  for (std::size_t points = 10'000; points <= most; points *= 10) {
    const Growth g = plan(points, nullptr);
    std::printf("%s{\"points\": %zu, \"plan_s\": %.3f, \"us_per_point\": %.2f, \"rss_mb\": %.2f}",
                points > 10'000 ? ", " : "", g.points, g.plan_s, 1e6 * g.plan_s / static_cast<double>(points),
                g.rss_mb);
    std::fflush(stdout);
  }
  std::printf("]}\n");
  return 0;
}
