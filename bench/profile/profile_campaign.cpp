// Many random cases of state-to-state motion, each in m, mm and um: are all solved, are all right, are durations the
// same whatever the unit?     build/release/bin/profile_campaign --cases 10000000 Ends with 0 when nothing failed.
// Profiles are integrated again in long double (reintegrated.hpp).
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <random>

#include "bench/profile/between_limits.hpp"
#include "bench/profile/reintegrated.hpp"

namespace gantry::bench {
namespace {

struct Count {
  std::uint64_t cases = 0, failed = 0, wrong = 0, other_duration = 0;
  double worst_end = 0, worst_limit = 0, worst_duration = 0;
};

class Draw {
 public:
  Draw(unsigned seed, bool one_sided) : random_(seed), one_sided_(one_sided) {}
  void next(motion::State& from, motion::State& to, motion::AxisBounds& b) {
    do {
      b = {bound(), bound(), bound()};
      if (one_sided_) b.v_min = -bound(), b.a_min = -bound(), b.j_min = -bound();
      from = {4 * normal_(random_), some(), some()};
      to = {4 * normal_(random_), some(), some()};
    } while (!stays(from, b, 1) || !stays(to, b, -1));
  }
  /// The state itself, off by a few roundings.
  motion::State near(const motion::State& x) {
    const auto off = [&](double v) { return v * (1 + 4e-16 * (unit_(random_) - 0.5)); };
    return {off(x.p), off(x.v), off(x.a)};
  }

 private:
  static bool stays(const motion::State& x, const motion::AxisBounds& b, int sign) {
    const double jerk = (x.a > 0) == (sign > 0) ? -b.j_min : b.j_max,
                 other = x.v + sign * x.a * std::abs(x.a) / (2 * jerk);
    return std::max(x.v, other) <= b.v_max && std::min(x.v, other) >= b.v_min && x.a <= b.a_max && x.a >= b.a_min;
  }
  double bound() { return 0.08 + 15.92 * unit_(random_); }
  double some() { return unit_(random_) < 0.25 ? 0.0 : 0.8 * normal_(random_); }
  std::mt19937_64 random_;
  bool one_sided_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_{0, 1};
};

motion::State in_unit(const motion::State& x, double unit) { return {x.p * unit, x.v * unit, x.a * unit}; }
motion::AxisBounds in_unit(const motion::AxisBounds& b, double unit) {
  return {b.v_max * unit, b.v_min * unit, b.a_max * unit, b.a_min * unit, b.j_max * unit, b.j_min * unit};
}

void take(Count& count, const motion::State& from, const motion::State& to, const motion::AxisBounds& b) {
  double reference = -1;
  for (const double unit : {1.0, 1e3, 1e6}) {
    const auto bounds = in_unit(b, unit);
    const motion::State target = in_unit(to, unit);
    const motion::Plan plan = motion::move(in_unit(from, unit), target, bounds);
    ++count.cases;
    if (!plan) {
      ++count.failed;
      continue;
    }
    const Excess e = reintegrate(plan.profile, target, bounds, true, true);
    count.worst_end = std::max(count.worst_end, e.end), count.worst_limit = std::max(count.worst_limit, e.limit);
    count.wrong += e.end > 1e-9 || e.limit > 1e-9;
    const double t = motion::duration(plan.profile);
    if (reference < 0) reference = t;
    const double off = std::abs(t - reference) / std::max(reference, 1e-9);
    count.worst_duration = std::max(count.worst_duration, off);
    count.other_duration += off > 1e-9;
  }
}

bool tell(const char* what, const Count& c) {
  std::printf("%-28s %9lu solved of %lu; %lu wrong (end %.1e, limit %.1e); %lu of another duration (%.1e)\n", what,
              c.cases - c.failed, c.cases, c.wrong, c.worst_end, c.worst_limit, c.other_duration, c.worst_duration);
  std::fflush(stdout);
  return c.failed + c.wrong + c.other_duration == 0;
}

bool run(std::uint64_t cases, unsigned seed) {
  bool good = true;
  for (const bool one_sided : {false, true}) {
    Draw draw(seed, one_sided);
    Count random, noise;
    motion::State from, to;
    motion::AxisBounds b;
    for (std::uint64_t i = 0; i < cases; ++i) {
      draw.next(from, to, b);
      take(random, from, to, b);
    }
    for (std::uint64_t i = 0; i < cases / 10; ++i) {
      draw.next(from, to, b);
      to = draw.near(from);
      const motion::Plan plan = motion::move(from, to, b);
      ++noise.cases;
      noise.failed += plan.reason == motion::Reason::NoSolution || (plan && motion::duration(plan.profile) > 1e-9);
    }
    good &= tell(one_sided ? "one-sided bounds" : "symmetric bounds", random);
    good &= tell("target within rounding", noise);
  }
  return good;
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  CLI::App app{"Random cases of state-to-state motion in three units"};
  std::uint64_t cases = 1000000, limited_cases = 10000;
  unsigned seed = 1;
  app.add_option("--cases", cases, "each in three units")->capture_default_str();
  app.add_option("--limited", limited_cases, "several axes between position limits")->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const bool open = gantry::bench::run(cases, seed), limited = gantry::bench::between_limits(limited_cases, seed);
  return open && limited ? 0 : 1;
}
