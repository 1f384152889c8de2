// How long the planner takes, in yards: time for a fixed chain of dependent double arithmetic, so that the figures of
// two machines can be compared.  taskset -c 1 build/release/bin/profile_speed
// Cases as the field draws them: p ~ N(0, 4), v and a ~ N(0, 0.8), each zero with probability 0.25, bounds ~ U(0.08,
// 16); target within the bounds. Least of 5 runs a case.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "bench/yard.hpp"
#include "motion/profile/together.hpp"

namespace gantry::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct Times {
  double median = 0, p99 = 0, p999 = 0, max = 0;
};

template <class Call>
Times times_of(std::size_t cases, int inner, Call&& call) {
  std::vector<double> best(cases, 1e300);
  for (int run = 0; run < 5; ++run)
    for (std::size_t i = 0; i < cases; ++i) {
      const auto begin = Clock::now();
      for (int k = 0; k < inner; ++k) call(i);
      const double ns = std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / inner;
      best[i] = std::min(best[i], ns);
    }
  std::sort(best.begin(), best.end());
  const auto at = [&](double q) { return best[static_cast<std::size_t>(q * static_cast<double>(cases - 1))]; };
  return {at(0.5), at(0.99), at(0.999), best.back()};
}

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  motion::AxisMove axis() {
    for (;;) {
      motion::AxisMove m;
      m.bounds = {bound_(random_), bound_(random_), bound_(random_)};
      m.from = {4 * normal_(random_), some(), some()};
      m.to = {4 * normal_(random_), some(), some()};
      const motion::AxisBounds& b = m.bounds;
      const double before = m.to.v - m.to.a * std::abs(m.to.a) / (2 * b.j_max);
      if (std::max(std::abs(m.to.v), std::abs(before)) <= b.v_max && std::abs(m.to.a) <= b.a_max) return m;
    }
  }

 private:
  double some() { return unit_(random_) < 0.25 ? 0.0 : 0.8 * normal_(random_); }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_{0, 1}, bound_{0.08, 16};
};

void measure(std::size_t cases, unsigned seed) {
  Draw draw(seed);
  std::vector<double> x(cases);
  std::mt19937_64 random(seed);
  for (double& v : x) v = std::uniform_real_distribution<double>(0, 1)(random);
  volatile double sink = 0;
  const double yard_ns = times_of(cases, 4, [&](std::size_t i) { sink = sink + yard(x[i]); }).median;
  std::printf("1 yd = %.0f ns; %zu cases, least of 5 runs, in yd\n%-22s %8s %8s %8s %8s\n", yard_ns, cases, "",
              "median", "p99", "p99.9", "max");
  const auto print = [&](const char* what, const Times& t) {
    std::printf("%-22s %8.2f %8.2f %8.2f %8.2f\n", what, t.median / yard_ns, t.p99 / yard_ns, t.p999 / yard_ns,
                t.max / yard_ns);
  };
  for (const std::size_t axes : {1u, 3u, 6u}) {
    std::vector<motion::AxisMove> moves;
    for (std::size_t i = 0; i < cases * axes; ++i) moves.push_back(draw.axis());
    if (axes == 1) {
      print("1 axis", times_of(cases, 1, [&](std::size_t i) {
              const auto plan = motion::move(moves[i].from, moves[i].to, moves[i].bounds, motion::Outside::Soonest);
              asm volatile("" : : "r"(&plan) : "memory");
            }));
      print("velocity, 1 axis", times_of(cases, 1, [&](std::size_t i) {
              const auto plan = motion::change_speed(moves[i].from, moves[i].to.v, moves[i].bounds, moves[i].to.a);
              asm volatile("" : : "r"(&plan) : "memory");
            }));
      continue;
    }
    const std::string name = std::to_string(axes) + " axes together";
    print(name.c_str(), times_of(cases, 1, [&](std::size_t i) {
            const auto joint =
                motion::move_together(std::span(moves).subspan(i * axes, axes), {.outside = motion::Outside::Soonest});
            asm volatile("" : : "r"(&joint) : "memory");
          }));
  }
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  CLI::App app{"Time of the state-to-state planner, in yards"};
  std::size_t cases = 100000;
  unsigned seed = 1;
  app.add_option("--cases", cases, "a kind")->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  gantry::bench::measure(cases, seed);
  return 0;
}
