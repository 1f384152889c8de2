// Beads of lines and arcs at speeds that their radii allow, and beads with a right angle: how steady is the speed?
//   bead_speed [--beads 500] [--seed 1] [--a 3000] [--j 50000]
// Speeds are differences of the planned positions, 1 ms apart and not rounded. Allowed is v^2/R <= a, v^3/R^2 <= j and,
// where a line becomes an arc within the bead, v^3 <= j R sqrt(24 R tolerance). One in three begins with an arc, one in
// three ends with one, where the run-up or run-out has to be bent. In a right angle one axis stops and the other sets
// out; the slowed length, below 0.95 v, is compared with that of two stops at the axes' limits which overlap by so much
// that the tool leaves the corner by the tolerance.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "motion/geometry.hpp"
#include "motion/path/bead.hpp"

namespace gantry::bench {
namespace {

constexpr double kV = 200, kTick = 0.001, kSlow = 0.05;
constexpr double kFine_s = 2e-5;  ///< for lengths, which a tick at 50 mm/s would make uncertain by 0.05 mm

struct Machine {
  double a = 3000, j = 50000;  ///< of each axis
  [[nodiscard]] motion::Limits limits() const {
    motion::Limits m;
    m.axes = 2, m.tick_s = kTick;
    for (std::size_t i = 0; i < 2; ++i) m.axis[i] = {-1e6, 1e6, kV, a, j}, m.linear[i] = true;
    return m;
  }
};

/// Speeds of the bead at even times, run-up and run-out left out; nothing where it is not planned.
std::vector<double> speeds(const Machine& m, const std::vector<AxisVec>& points, double speed, double tolerance,
                           double every_s) {
  motion::BeadSpec spec;
  spec.points = points, spec.speed_mm_s = speed, spec.corner_tolerance_mm = tolerance;
  const auto bead = plan_bead(m.limits(), spec);
  std::vector<double> out;
  if (!bead) return out;
  AxisVec last{};
  double t = 0;  // from the bead's begin to that of the segment
  std::size_t tick = 0;
  for (std::size_t k = bead->bead_begin; k < bead->bead_end; ++k) {
    const motion::Segment& s = bead->segments[k];
    double length_s = 0;
    for (const motion::Phase& p : s.nominal.phases) length_s += p.duration_s;
    for (; static_cast<double>(tick) * every_s < t + length_s - 1e-9; ++tick) {
      motion::State x{0, s.nominal.v0, s.nominal.a0};
      double left = static_cast<double>(tick) * every_s - t;
      for (const motion::Phase& p : s.nominal.phases) {
        const double step = std::min(left, p.duration_s);
        x = motion::advanced(x, p.jerk, step), left -= step;
      }
      const AxisVec q = motion::point(s.geometry, x.p);
      if (tick > 0) out.push_back(std::hypot(q[0] - last[0], q[1] - last[1]) / every_s);
      last = q;
    }
    t += length_s;
  }
  return out;
}

struct Steady {
  double within_5 = 1, within_1 = 1, worst = 0;  ///< shares of the length; largest |v/v_set - 1|
};

Steady steadiness(const std::vector<double>& v, double speed) {
  Steady out;
  double all = 0, five = 0, one = 0;
  for (const double x : v) {
    const double off = std::abs(x / speed - 1);
    all += x, five += off <= kSlow ? x : 0, one += off <= 0.01 ? x : 0;
    out.worst = std::max(out.worst, off);
  }
  out.within_5 = five / all, out.within_1 = one / all;
  return out;
}

struct Drawn {
  std::vector<AxisVec> points;
  double allowed_mm_s = kV, tolerance = 0;
};

/// Lines of 10 to 60 mm with arcs between them and at some ends, in chords whose sagitta is a tenth of the tolerance at
/// most.
Drawn lines_and_arcs(const Machine& m, std::mt19937_64& random) {
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  Drawn out;
  out.tolerance = std::pow(10.0, uniform(-2, -0.5));
  double angle = uniform(0, 6.28), x = 0, y = 0;
  const auto put = [&] { out.points.push_back(AxisVec{x, y}); };
  const auto line = [&] {
    const double length = uniform(10, 60);
    x += length * std::cos(angle), y += length * std::sin(angle);
    put();
  };
  const bool arc_first = uniform(0, 3) < 1, arc_last = uniform(0, 3) < 1;
  const int arcs = 1 + static_cast<int>(uniform(0, 5));
  put();
  if (!arc_first) line();
  for (int n = 0; n < arcs; ++n) {
    const bool alone = arcs == 1 && arc_first && arc_last;  // long enough that whole ticks do not count
    const double r = std::pow(10.0, uniform(0, 1.7)), turn = alone ? uniform(3, 6.2) : uniform(0.3, 3),
                 side = uniform(0, 1) < 0.5 ? -1 : 1;
    const double most = std::min(1.0, std::sqrt(0.8 * r * out.tolerance));
    const int chords = static_cast<int>(std::ceil(turn * r / most / uniform(0.2, 1)));
    const double cx = x - side * r * std::sin(angle), cy = y + side * r * std::cos(angle);
    for (int k = 0; k < chords; ++k) {
      angle += side * turn / chords;
      x = cx + side * r * std::sin(angle), y = cy - side * r * std::cos(angle);
      put();
    }
    if (n + 1 < arcs || !arc_last) line();
    out.allowed_mm_s = std::min({out.allowed_mm_s, std::sqrt(m.a * r), std::cbrt(m.j * r * r)});
    if (!alone) out.allowed_mm_s = std::min(out.allowed_mm_s, std::cbrt(m.j * r * std::sqrt(24 * r * out.tolerance)));
  }
  return out;
}

/// An axis that stops from v at its limits.
class Stop {
 public:
  Stop(const Machine& m, double v)
      : v_(v), j_(m.j), a_(std::min(m.a, std::sqrt(v * m.j))), rise_(a_ / m.j), hold_(v / a_ - rise_) {}
  [[nodiscard]] double seconds() const { return 2 * rise_ + hold_; }
  [[nodiscard]] double speed(double t) const {
    const double left = seconds() - t;
    if (t <= 0) return v_;
    if (left <= 0) return 0;
    if (left < rise_) return j_ * left * left / 2;
    return t < rise_ ? v_ - j_ * t * t / 2 : v_ - j_ * rise_ * rise_ / 2 - a_ * (t - rise_);
  }
  /// What it goes in its last seconds.
  [[nodiscard]] double last_mm(double last_s) const {
    double mm = 0;
    for (double t = seconds() - last_s; t < seconds(); t += kFine_s) mm += speed(t + kFine_s / 2) * kFine_s;
    return mm;
  }

 private:
  double v_, j_, a_, rise_, hold_;
};

/// Slowed length of a right angle in which one axis stops from v and the other one sets out alike, as early as leaves
/// the corner by the tolerance where both are equally far from it; no earlier than the first one brakes.
double overlapped_mm(const Machine& m, double v, double tolerance) {
  const Stop stop(m, v);
  double low = 0, high = stop.seconds();
  for (int n = 0; n < 40; ++n) {
    const double overlap = (low + high) / 2;
    (std::sqrt(2) * stop.last_mm(overlap / 2) < tolerance ? low : high) = overlap;
  }
  const double all = 2 * stop.seconds() - low;
  double slowed = 0;
  for (double t = kFine_s / 2; t < all; t += kFine_s) {
    const double speed = std::hypot(stop.speed(t), stop.speed(all - t));
    if (speed < (1 - kSlow) * v) slowed += speed * kFine_s;
  }
  return slowed;
}

int smooth(const Machine& m, std::uint64_t beads, std::uint64_t seed) {
  std::printf("lines and arcs, speed as a share of what is allowed:\n");
  bool good = true;
  for (const double share : {0.3, 0.6, 0.8, 0.9, 0.97, 1.0}) {
    double least_5 = 1, least_1 = 1, worst = 0, sum_1 = 0;
    std::uint64_t under = 0, planned = 0, worst_seed = 0;
    for (std::uint64_t n = seed; n < seed + beads; ++n) {
      std::mt19937_64 random(n);
      const Drawn d = lines_and_arcs(m, random);
      const double speed = share * d.allowed_mm_s;
      const auto v = speeds(m, d.points, speed, d.tolerance, kTick);
      if (v.empty()) continue;
      const Steady s = steadiness(v, speed);
      ++planned, under += s.within_5 < 0.98, sum_1 += s.within_1;
      if (s.worst > worst) worst = s.worst, worst_seed = n;
      least_5 = std::min(least_5, s.within_5), least_1 = std::min(least_1, s.within_1);
    }
    std::printf(
        "  %.2f: %llu of %llu beads; within 5 %% over at least %.4f of each (%llu below 0.98), within 1 %% over "
        "%.4f in the mean and %.4f at least; farthest off %.4f (seed %llu)\n",
        share, static_cast<unsigned long long>(planned), static_cast<unsigned long long>(beads), least_5,
        static_cast<unsigned long long>(under), sum_1 / static_cast<double>(planned), least_1, worst,
        static_cast<unsigned long long>(worst_seed));
    good = good && under == 0;
  }
  return good ? 0 : 1;
}

/// The tolerances go from a corner that is hardly rounded to one that is as large as a stop.
int corners(const Machine& m) {
  constexpr std::array kSpeeds{10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0, 110.0, 150.0, 190.0};
  std::printf(
      "right angles between legs of 60 mm: slowed length as a share of that of two stops that overlap\n  mm   ");
  for (const double speed : kSpeeds) std::printf(" %4.0f mm/s", speed);
  std::printf("\n");
  double most = 0;
  for (const double tolerance : {0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8}) {
    std::printf("  %.2f ", tolerance);
    for (const double speed : kSpeeds) {
      const auto v = speeds(m, {AxisVec{0, 0}, AxisVec{60, 0}, AxisVec{60, 60}}, speed, tolerance, kFine_s);
      double slowed = 0;
      for (const double x : v) slowed += x < (1 - kSlow) * speed ? x * kFine_s : 0;
      // One that is not planned, or slowed where it need not be at all, is far above any other.
      const double bound = overlapped_mm(m, speed, tolerance);
      const double share = v.empty() || (slowed > 0 && !(bound > 0)) ? 99 : slowed > 0 ? slowed / bound : 0;
      most = std::max(most, share);
      std::printf("     %.3f", share);
    }
    std::printf("\n");
  }
  std::printf("  at most %.3f\n", most);
  return most <= 1.1 ? 0 : 1;
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  std::uint64_t beads = 500, seed = 1;
  CLI::App app{"measures how steady the speed of beads is"};
  app.add_option("--beads", beads);
  app.add_option("--seed", seed, "of the first bead; the others follow");
  gantry::bench::Machine machine;
  app.add_option("--a", machine.a, "acceleration of each axis, mm/s^2")->check(CLI::PositiveNumber);
  app.add_option("--j", machine.j, "jerk of each axis, mm/s^3")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  const int a = gantry::bench::smooth(machine, beads, seed), b = gantry::bench::corners(machine);
  return a != 0 || b != 0 ? 1 : 0;
}
