// Many random polylines: is each planned, within limits and tolerance, never backwards, never at rest between the ends?
//   path_campaign --cases 100000 --seed 1 [--dump DIR]
// Chords of 0.01 to 20 mm; straight on with mismatches of 1e-12 to 1e-3 mm, gentle bends, corners, reversals, points
// twice; tolerances 0 to 1 mm. Judged on 1 ms setpoints by differences and by distances to all segments. Ends with 0
// when nothing failed; --dump writes the polylines that did.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "motion/path/path_planner.hpp"
#include "tests/motion/path/path_cursor.hpp"

namespace gantry::bench {
namespace {

constexpr double kV = 200, kA = 3000, kJ = 50000, kTick = 0.001;
using Point = std::array<double, 3>;

struct Case {
  std::vector<Point> points;
  double tolerance = 0, speed = 400;
  std::size_t axes = 2;
};

Case draw(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto power = [&](double low, double high) { return std::pow(10.0, low + (high - low) * unit(random)); };
  Case c;
  constexpr std::array<double, 7> kTolerances = {0, 1e-6, 1e-3, 0.01, 0.05, 0.2, 1};
  c.tolerance = kTolerances[static_cast<std::size_t>(unit(random) * 7)];
  if (unit(random) < 0.5) c.tolerance = power(-6, 0);
  if (unit(random) < 0.3) c.speed = power(0, 2.3);
  c.axes = unit(random) < 0.25 ? 3 : 2;
  const auto n = static_cast<std::size_t>(2 + 30 * unit(random));
  const double longest = power(-1.5, 1.3), noise = power(-12, -3);
  const double straight = unit(random), gentle = unit(random);
  double angle = 6.28 * unit(random), rise = 0, bend = 0;
  Point p{};
  c.points.push_back(p);
  while (c.points.size() < n) {
    const double kind = unit(random);
    if (kind > straight) {
      const double sharp = unit(random);
      if (sharp < gentle)
        bend = 0.3 * (unit(random) - 0.5), angle += bend;
      else if (sharp > 0.97)
        angle += 3.14159265358979323846;
      else
        angle += 6.28 * unit(random);
      rise = c.axes == 3 ? unit(random) - 0.5 : 0;
    } else {
      angle += unit(random) < 0.5 ? bend : 0;
    }
    const double chord = std::max(0.01, longest * (unit(random) < 0.5 ? 1 : power(-2, 0)));
    p[0] += chord * std::cos(angle) + noise * (unit(random) - 0.5);
    p[1] += chord * std::sin(angle) + noise * (unit(random) - 0.5);
    p[2] += chord * rise;
    c.points.push_back(p);
    if (unit(random) < 0.02) c.points.push_back(p);
  }
  return c;
}

double distance(const Point& q, const Point& a, const Point& b) {
  double ab = 0, aq = 0, sum = 0;
  for (std::size_t i = 0; i < 3; ++i) ab += (b[i] - a[i]) * (b[i] - a[i]), aq += (q[i] - a[i]) * (b[i] - a[i]);
  const double on = ab > 0 ? std::clamp(aq / ab, 0.0, 1.0) : 0;
  for (std::size_t i = 0; i < 3; ++i) sum += std::pow(q[i] - a[i] - on * (b[i] - a[i]), 2);
  return std::sqrt(sum);
}

/// Empty when all is well.
std::string judged(const Case& c, double& seconds) {
  motion::Limits limits;
  limits.axes = c.axes;
  limits.tick_s = kTick;
  for (std::size_t i = 0; i < c.axes; ++i) limits.axis[i] = {-HUGE_VAL, HUGE_VAL, kV, kA, kJ}, limits.linear[i] = true;
  motion::PathPlanner planner(limits, {.tolerance_mm = c.tolerance, .speed_mm_s = c.speed});
  std::vector<motion::Stretch> stretches;
  motion::Stretch stretch;
  for (const Point& p : c.points) {
    AxisVec q{};
    std::copy(p.begin(), p.end(), q.begin());
    if (const auto ok = planner.add(q); !ok) return ok.error().message;
    while (planner.take(stretch)) stretches.push_back(stretch);
  }
  if (const auto ok = planner.finish(); !ok) return ok.error().message;
  while (planner.take(stretch)) stretches.push_back(stretch);
  if (planner.counts().forced_rests > 0) return "a forced rest";

  std::vector<Point> x;
  double begin = 0;
  std::size_t tick = 0, slow = 0;
  std::string wrong;
  for (const motion::Stretch& s : stretches) {
    motion::test::PathCursor cursor;
    double last_s = -1;
    for (;; ++tick) {
      const double t = static_cast<double>(tick) * kTick - begin;
      if (t >= s.duration_s - 1e-9) break;
      const auto at = cursor.at(s, t, c.axes);
      x.push_back({at.q[0], at.q[1], c.axes > 2 ? at.q[2] : 0});
      if (at.s < last_s || at.s_dot < 0) wrong = "backwards";
      if (at.s_dot > 1.001 * c.speed) wrong = "too fast: " + std::to_string(at.s_dot / c.speed);
      last_s = at.s;
    }
    begin += s.duration_s;
  }
  seconds = begin;
  x.push_back(c.points.back());
  for (const Point& p : x) {
    double best = HUGE_VAL;
    for (std::size_t k = 1; k < c.points.size(); ++k) best = std::min(best, distance(p, c.points[k - 1], c.points[k]));
    if (best > c.tolerance + 1e-7) wrong = "off by " + std::to_string(best) + " of " + std::to_string(c.tolerance);
  }
  if (c.tolerance > 0)
    for (std::size_t k = 10; k + 13 < x.size(); ++k) slow += distance(x[k], x[k + 3], x[k + 3]) < 1e-7;
  if (slow > 0) wrong = "a standstill";
  for (std::size_t i = 0; i < c.axes; ++i) {
    std::vector<double> d(4, x.front()[i]);
    for (const Point& p : x) d.push_back(p[i]);
    d.insert(d.end(), 4, x.back()[i]);
    for (const double most : {kV, kA, kJ}) {
      for (std::size_t k = 0; k + 1 < d.size(); ++k) d[k] = (d[k + 1] - d[k]) / kTick;
      d.pop_back();
      for (const double y : d)
        if (std::abs(y) > 1.01 * most) wrong = "a limit of " + std::to_string(most) + ": " + std::to_string(y);
    }
  }
  return wrong;
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  std::uint64_t cases = 1000, seed = 1;
  std::string dump;
  CLI::App app{"plans and judges random polylines"};
  app.add_option("--cases", cases);
  app.add_option("--seed", seed, "of the first case; the others follow");
  app.add_option("--dump", dump, "folder for polylines that failed");
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::uint64_t failed = 0;
  double all = 0;
  for (std::uint64_t n = seed; n < seed + cases; ++n) {
    const gantry::bench::Case c = gantry::bench::draw(n);
    double seconds = 0;
    const std::string wrong = gantry::bench::judged(c, seconds);
    all += seconds;
    if (wrong.empty()) continue;
    if (++failed <= 30) std::printf("seed %lu, tolerance %g, speed %g: %s\n", n, c.tolerance, c.speed, wrong.c_str());
    if (dump.empty()) continue;
    std::FILE* out = std::fopen((dump + "/" + std::to_string(n) + ".csv").c_str(), "w");
    if (out == nullptr) continue;
    std::fputs(c.axes == 3 ? "x,y,z\n" : "x,y\n", out);
    for (const auto& p : c.points)
      c.axes == 3 ? std::fprintf(out, "%.17g,%.17g,%.17g\n", p[0], p[1], p[2])
                  : std::fprintf(out, "%.17g,%.17g\n", p[0], p[1]);
    std::fclose(out);
  }
  std::printf("%lu polylines, %.1f s of motion, %lu failed\n", cases, all, failed);
  return failed == 0 ? 0 : 1;
}
