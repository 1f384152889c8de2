// The planner beside FCL (dynamic tree, poses 0.5 mm apart) and OMPL with that as its validator, in one run:
//   taskset -c 1 build/release/bin/plan_speed
// Each table row is a pallet of so many parts. Times are medians over the questions; "x" is how many times faster. Ends
// with 1 when a figure is missed that is asked of that many parts (kAsked), which it then names.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <ompl/util/RandomNumbers.h>

#include "bench/plan/fcl_planner.hpp"
#include "bench/plan/pallet.hpp"
#include "bench/yard.hpp"
#include "motion/plan/certificate.hpp"
#include "motion/plan/lift_over.hpp"
#include "motion/plan/search_path.hpp"

namespace gantry::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Numbers = std::vector<double>;
constexpr int kInner = 4;  // calls that are timed together, where the clock would cost more than one

double median(Numbers v) {
  if (v.empty()) return 0;
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}
/// Least of `runs`, in microseconds.
template <class Call>
double us(int runs, Call&& call) {
  double best = 1e300;
  for (int i = 0; i < runs; ++i) {
    const auto begin = Clock::now();
    call();
    best = std::min(best, std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
  }
  return best;
}
Vec3 tip(const AxisVec& q) { return {q[0], q[1], q[2]}; }

double yard_us() {
  Numbers all;
  std::mt19937_64 random(1);
  volatile double sink = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = std::uniform_real_distribution<double>(0, 1)(random);
    all.push_back(us(5,
                     [&] {
                       for (int k = 0; k < 4; ++k) sink = sink + yard(x);
                     }) /
                  4);
  }
  return median(all);
}

constexpr double kAnything = std::numeric_limits<double>::infinity();

/// What is asked of the medians among so many parts.
struct Asked {
  int parts = 0;
  double verdict_x = 0, plan_x = 0;  ///< times faster than FCL, than OMPL with FCL: at least
  double length_by_straight = kAnything, certified_yd = kAnything;  ///< at most
};
constexpr Asked kAsked[] = {{200, 200, 25, 1.07}, {2000, 100, 20, 1.24, 67}};

Asked asked_of(int parts) {
  for (const Asked& asked : kAsked)
    if (asked.parts == parts) return asked;
  return {parts};
}

int missed_figures = 0;
void expect(bool met, const char* what, double is, double asked) {
  if (met) return;
  ++missed_figures;
  std::printf("  missed: %s is %.4g, asked is %.4g\n", what, is, asked);
}
void at_least(const char* what, double is, double asked) { expect(is >= asked, what, is, asked); }
void at_most(const char* what, double is, double asked) { expect(is <= asked, what, is, asked); }

void verdicts(const motion::Scene& scene, FclScene& fcl, const std::vector<Line>& asked, double yard,
              const Asked& figures) {
  const motion::Margins margins{};
  Numbers ours, theirs, certified;
  int free = 0, contradicted = 0, missed = 0;
  for (const Line& line : asked) {
    bool is_free = false, fcl_free = false;
    ours.push_back(us(5,
                      [&] {
                        for (int k = 0; k < kInner; ++k) is_free = motion::is_clear(scene, line.from, line.to, margins);
                      }) /
                   kInner);
    theirs.push_back(us(2, [&] { fcl_free = fcl.line_is_free(tip(line.from), tip(line.to)); }));
    free += is_free, contradicted += is_free && !fcl_free, missed += !is_free && fcl_free;
    const std::array<AxisVec, 2> both{line.from, line.to};
    if (is_free)
      certified.push_back(us(5, [&] {
        const auto proof = motion::certify(scene, both, {.clearance_mm = 0, .approaches = {}});
        if (!proof) std::abort();
      }));
  }
  std::printf(
      "  verdict: FCL %.1f us, ours %.3f us, %.0f x; %d of %zu free, of which FCL contradicts %d; FCL misses %d hits\n",
      median(theirs), median(ours), median(theirs) / median(ours), free, asked.size(), contradicted, missed);
  std::printf("  certified motion: %.2f us, %.0f yd\n", median(certified), median(certified) / yard);
  at_least("times a verdict is faster than FCL", median(theirs) / median(ours), figures.verdict_x);
  at_most("yards of a certified motion", median(certified) / yard, figures.certified_yd);
  at_most("motions called free that FCL contradicts", contradicted, 0);
}

void plans(const motion::Scene& scene, FclScene& fcl, const std::vector<Line>& asked, const Asked& figures) {
  const motion::Margins margins{};
  Numbers ours, theirs, ratio, ratio_theirs, lift;
  int found = 0, longer = 0, colliding = 0;
  for (const Line& line : asked) {
    motion::SearchAnswer answer;
    const double mine = us(3, [&] {
      answer = motion::search_path(scene, line.from, line.to, margins);
      if (answer.status == motion::SearchStatus::Ok)
        if (!motion::certify(scene, answer.points, {.clearance_mm = 0, .approaches = {}})) std::abort();
    });
    std::vector<Vec3> path;
    const double other = us(1, [&] { path = fcl_plan(fcl, {0, 0, 0}, {400, 300, 100}, tip(line.from), tip(line.to)); });
    if (answer.status != motion::SearchStatus::Ok || path.empty()) continue;
    ++found;
    ours.push_back(mine), theirs.push_back(other);
    const double straight = norm(tip(line.to) - tip(line.from));
    ratio.push_back(answer.length_mm / straight);
    double length = 0;
    bool hits = false;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      length += norm(path[i + 1] - path[i]);
      hits = hits || !motion::is_clear(scene, {path[i].x, path[i].y, path[i].z},
                                       {path[i + 1].x, path[i + 1].y, path[i + 1].z}, margins);
    }
    colliding += hits;
    ratio_theirs.push_back(length / straight);
    if (const auto over = motion::lift_over(scene, line.from, line.to, margins)) {
      double up = 0;
      for (std::size_t i = 0; i + 1 < over->points.size(); ++i)
        up += norm(tip(over->points[i + 1]) - tip(over->points[i]));
      longer += answer.length_mm > up + 1e-9;
      lift.push_back(up / straight);
    }
  }
  std::printf("  plan: OMPL %.0f us, ours %.0f us, %.1f x; %d of %zu by both\n", median(theirs), median(ours),
              median(theirs) / median(ours), found, asked.size());
  std::printf(
      "  length / straight: OMPL %.3f, lift-over %.3f, ours %.3f; %d of ours longer than lift-over; "
      "%d of OMPL's collide\n",
      median(ratio_theirs), median(lift), median(ratio), longer, colliding);
  at_least("times a plan is faster than OMPL", median(theirs) / median(ours), figures.plan_x);
  at_most("length by the straight line", median(ratio), figures.length_by_straight);
  at_most("paths longer than lift-over", longer, 0);
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  using namespace gantry;
  CLI::App app{"The planner beside FCL and OMPL"};
  int motions = 1000, queries = 200;
  std::uint64_t seed = 1;
  std::vector<int> sizes{20, 200, 2000};
  app.add_option("--motions", motions)->capture_default_str();
  app.add_option("--queries", queries)->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  app.add_option("--parts", sizes)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  ompl::RNG::setSeed(static_cast<std::uint_fast32_t>(seed));
  const double yard = bench::yard_us();
  std::printf("1 yd = %.3f us\n", yard);
  for (const int parts : sizes) {
    const config::Machine machine = bench::pallet(parts, seed);
    const motion::Scene scene(machine);
    bench::FclScene fcl(machine);
    std::printf("%d parts\n", parts);
    bench::verdicts(scene, fcl, bench::lines(scene, motions, seed + 1, false), yard, bench::asked_of(parts));
    bench::plans(scene, fcl, bench::lines(scene, queries, seed + 2, true), bench::asked_of(parts));
  }
  return bench::missed_figures == 0 ? 0 : 1;
}
