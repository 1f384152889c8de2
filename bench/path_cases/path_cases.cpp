// Plans a path along a polyline and prints what came out as one line of JSON:
//   path_cases FILE.csv --v 200 --a 3000 --j 50000 --tol 0.05 [--speed 40] [--setpoints out.csv]
// {total_s, v_max[], a_max[], j_max[], deviation_mm, plan_us, bound_s}: maxima by differences of the 1 ms setpoints,
// with the machine at rest before and after; deviation of the setpoints from the polyline; plan_us for the whole path,
// the least of --runs; bound_s a lower bound of the time that knows nothing of the plan (bound.hpp).
// --setpoints: t,x,y[,z] from t = 0 to the exact end.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "bench/path_cases/bound.hpp"
#include "bench/path_cases/polyline_csv.hpp"
#include "motion/path/path_cursor.hpp"
#include "motion/path/path_planner.hpp"

namespace gantry::bench {
namespace {

using Point = std::array<double, 3>;
constexpr double kTick = 0.001;

struct Options {
  std::string file, setpoints;
  double v = 200, a = 3000, j = 50000, tolerance = 0.05, speed = HUGE_VAL;
  int runs = 1;
};

motion::Limits limits_of(const Options& o, std::size_t axes) {
  motion::Limits limits;
  limits.axes = axes;
  limits.tick_s = kTick;
  for (std::size_t i = 0; i < axes; ++i) {
    limits.axis[i] = {-HUGE_VAL, HUGE_VAL, o.v, o.a, o.j};
    limits.linear[i] = true;
  }
  return limits;
}

struct Planned {
  std::vector<motion::Stretch> stretches;
  motion::PathPlanner::Counts counts;
  double seconds = 0;  ///< of planning
};

Result<Planned> plan(const Options& o, const Polyline& polyline) {
  const motion::Limits limits = limits_of(o, polyline.axes);
  // No speed asked for: more than all axes together allow.
  const double speed = std::isfinite(o.speed) ? o.speed : 2 * o.v;
  Planned out;
  const auto begin = std::chrono::steady_clock::now();
  motion::PathPlanner planner(limits, {.tolerance_mm = o.tolerance, .speed_mm_s = speed});
  motion::Stretch stretch;
  for (const Point& p : polyline.points) {
    AxisVec q{};
    std::copy(p.begin(), p.end(), q.begin());
    if (const auto ok = planner.add(q); !ok) return tl::unexpected(ok.error());
    while (planner.take(stretch)) out.stretches.push_back(std::move(stretch));
  }
  if (const auto ok = planner.finish(); !ok) return tl::unexpected(ok.error());
  while (planner.take(stretch)) out.stretches.push_back(std::move(stretch));
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  out.counts = planner.counts();
  return out;
}

/// Positions every tick, and one at the exact end.
std::vector<std::pair<double, Point>> sampled(const Planned& planned, const Polyline& polyline) {
  std::vector<std::pair<double, Point>> out;
  double begin = 0;
  std::size_t tick = 0;
  for (const motion::Stretch& s : planned.stretches) {
    motion::PathCursor cursor;
    for (;; ++tick) {
      const double t = static_cast<double>(tick) * kTick;
      if (t >= begin + s.duration_s - 1e-9) break;
      const auto x = cursor.at(s, t - begin, polyline.axes);
      out.push_back({t, {x.q[0], x.q[1], polyline.axes > 2 ? x.q[2] : 0}});
    }
    begin += s.duration_s;
  }
  out.push_back({begin, polyline.points.back()});
  return out;
}

double distance_to(const Point& q, const Point& a, const Point& b) {
  double ab = 0, aq = 0;
  for (std::size_t i = 0; i < 3; ++i) ab += (b[i] - a[i]) * (b[i] - a[i]), aq += (q[i] - a[i]) * (b[i] - a[i]);
  const double on = ab > 0 ? std::clamp(aq / ab, 0.0, 1.0) : 0;
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = q[i] - a[i] - on * (b[i] - a[i]);
    sum += x * x;
  }
  return std::sqrt(sum);
}

/// Largest distance of a setpoint from the polyline. The search goes along with the tool: only where the segments near
/// its last one would make the figure larger are all of them looked at.
double deviation(const std::vector<std::pair<double, Point>>& setpoints, const std::vector<Point>& points) {
  constexpr double kAhead = 5;  // mm
  std::vector<double> at(points.size(), 0);
  for (std::size_t k = 1; k < points.size(); ++k)
    at[k] = at[k - 1] + std::hypot(points[k][0] - points[k - 1][0], points[k][1] - points[k - 1][1],
                                   points[k][2] - points[k - 1][2]);
  double worst = 0;
  std::size_t last = 1;
  if (points.size() == 1) return 0;
  for (const auto& [t, q] : setpoints) {
    double best = HUGE_VAL;
    std::size_t nearest = last, k = last;
    while (k > 1 && at[k] > at[last] - 1) --k;
    for (; k < points.size() && at[k - 1] < at[last] + kAhead; ++k) {
      const double d = distance_to(q, points[k - 1], points[k]);
      if (d < best) best = d, nearest = k;
    }
    if (best > worst)
      for (k = 1; k < points.size(); ++k)
        if (const double d = distance_to(q, points[k - 1], points[k]); d < best) best = d, nearest = k;
    last = nearest;
    worst = std::max(worst, best);
  }
  return worst;
}

/// Largest n-th difference an axis, the machine standing before and after.
std::string largest(const std::vector<std::pair<double, Point>>& setpoints, std::size_t axes, int order) {
  std::string out = "[";
  for (std::size_t i = 0; i < axes; ++i) {
    std::vector<double> x(3, setpoints.front().second[i]);
    for (const auto& [t, q] : setpoints) x.push_back(q[i]);
    x.insert(x.end(), 3, setpoints.back().second[i]);
    for (int n = 0; n < order; ++n) {
      for (std::size_t k = 0; k + 1 < x.size(); ++k) x[k] = (x[k + 1] - x[k]) / kTick;
      x.pop_back();
    }
    double most = 0;
    for (const double y : x) most = std::max(most, std::abs(y));
    char text[40];
    std::snprintf(text, sizeof text, "%s%.6g", i > 0 ? ", " : "", most);
    out += text;
  }
  return out + "]";
}

int run(const Options& o) {
  std::ifstream file(o.file);
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n", o.file.c_str());
    return 2;
  }
  const Polyline polyline = read_polyline(file);
  if (!polyline.error.empty()) {
    std::fprintf(stderr, "%s: %s\n", o.file.c_str(), polyline.error.c_str());
    return 3;
  }
  Result<Planned> planned = plan(o, polyline);
  for (int n = 1; n < o.runs && planned; ++n) {
    Result<Planned> again = plan(o, polyline);
    if (again && again->seconds < planned->seconds) planned = std::move(again);
  }
  if (!planned) {
    std::fprintf(stderr, "%s: %s\n", o.file.c_str(), to_text(planned.error()).c_str());
    return 4;
  }
  const auto setpoints = sampled(*planned, polyline);
  const double bound = bound_s(polyline.points, {o.v, o.a, o.speed, o.tolerance});
  std::printf(
      "{\"total_s\": %.9g, \"v_max\": %s, \"a_max\": %s, \"j_max\": %s, \"deviation_mm\": %.6g, "
      "\"plan_us\": %.1f, \"bound_s\": %.9g}\n",
      setpoints.back().first, largest(setpoints, polyline.axes, 1).c_str(),
      largest(setpoints, polyline.axes, 2).c_str(), largest(setpoints, polyline.axes, 3).c_str(),
      deviation(setpoints, polyline.points), planned->seconds * 1e6, bound);
  const auto& c = planned->counts;
  std::fprintf(stderr,
               "curves %zu, windows %zu, second tries %zu, cells %zu, steps %zu, most waiting %zu, forced rests %zu\n",
               c.curves, c.windows, c.second_tries, c.cells, c.steps, c.most_waiting, c.forced_rests);
  if (!o.setpoints.empty()) {
    std::FILE* out = std::fopen(o.setpoints.c_str(), "w");
    if (out == nullptr) {
      std::fprintf(stderr, "%s: cannot be written\n", o.setpoints.c_str());
      return 2;
    }
    std::fputs("t,x,y,z\n", out);
    for (const auto& [t, q] : setpoints) std::fprintf(out, "%.17g,%.17g,%.17g,%.17g\n", t, q[0], q[1], q[2]);
    std::fclose(out);
  }
  return 0;
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  gantry::bench::Options o;
  CLI::App app{"plans a path along a polyline"};
  app.add_option("file", o.file, "CSV: header, then x,y[,z] in mm")->required();
  app.add_option("--v", o.v, "speed limit of each axis, mm/s")->check(CLI::PositiveNumber);
  app.add_option("--a", o.a, "acceleration limit of each axis, mm/s2")->check(CLI::PositiveNumber);
  app.add_option("--j", o.j, "jerk limit of each axis, mm/s3")->check(CLI::PositiveNumber);
  app.add_option("--tol", o.tolerance, "how far the path may leave the polyline, mm")->check(CLI::NonNegativeNumber);
  app.add_option("--speed", o.speed, "set speed of the tool, mm/s (default: what the axes allow)");
  app.add_option("--setpoints", o.setpoints, "file for the 1 ms setpoints");
  app.add_option("--runs", o.runs, "plan so often, tell the least time");
  CLI11_PARSE(app, argc, argv);
  return gantry::bench::run(o);
}
