// Plans a path along a polyline and prints what came out as one line of JSON:
//   path_cases FILE.csv --v 200 --a 3000 --j 50000 --tol 0.05 [--speed 40] [--setpoints out.csv]
// {total_s, v_max[], a_max[], j_max[], deviation_mm, plan_us, bound_s}: maxima by differences of the 1 ms setpoints,
// with the machine at rest before and after; deviation of the setpoints from the polyline; plan_us for the whole path,
// the least of --runs; bound_s a lower bound of the time that knows nothing of the plan (bound.hpp).
// --setpoints: t,x,y,z from t = 0 to the exact end, written as they come. A path of more than 1e8 setpoints is refused.
// Ends with 2 for a wrong call or a file that cannot be read or written, 3 for a wrong polyline, 4 where there is no
// plan.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include "bench/path_cases/bound.hpp"
#include "bench/path_cases/polyline_csv.hpp"
#include "motion/path/path_planner.hpp"
#include "tests/motion/path/path_cursor.hpp"

namespace gantry::bench {
namespace {

using Point = std::array<double, 3>;
constexpr double kTick = 0.001, kMostSetpoints = 1e8;

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

/// Visits positions every tick, and one at the exact end: visit(t, point).
template <class Visit>
void each_setpoint(const Planned& planned, const Polyline& polyline, Visit&& visit) {
  double begin = 0;
  std::size_t tick = 0;
  for (const motion::Stretch& s : planned.stretches) {
    motion::test::PathCursor cursor;
    for (;; ++tick) {
      const double t = static_cast<double>(tick) * kTick;
      if (t >= begin + s.duration_s - 1e-9) break;
      const auto x = cursor.at(s, t - begin, polyline.axes);
      visit(t, Point{x.q[0], x.q[1], polyline.axes > 2 ? x.q[2] : 0});
    }
    begin += s.duration_s;
  }
  visit(begin, polyline.points.back());
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

/// Largest distance of setpoints from the polyline. The search goes along with the tool: only where the segments near
/// its last one would make the figure larger are all of them looked at.
class Deviation {
 public:
  explicit Deviation(const std::vector<Point>& points) : points_(points), at_(points.size(), 0) {
    for (std::size_t k = 1; k < points.size(); ++k)
      at_[k] = at_[k - 1] + std::hypot(points[k][0] - points[k - 1][0], points[k][1] - points[k - 1][1],
                                       points[k][2] - points[k - 1][2]);
  }
  void add(const Point& q) {
    constexpr double kAhead = 5;  // mm
    if (points_.size() == 1) return;
    double best = HUGE_VAL;
    std::size_t nearest = last_, k = last_;
    const auto look = [&] {
      if (const double d = distance_to(q, points_[k - 1], points_[k]); d < best) best = d, nearest = k;
    };
    while (k > 1 && at_[k] > at_[last_] - 1) --k;
    for (; k < points_.size() && at_[k - 1] < at_[last_] + kAhead; ++k) look();
    if (best > worst_)
      for (k = 1; k < points_.size(); ++k) look();
    last_ = nearest;
    worst_ = std::max(worst_, best);
  }
  [[nodiscard]] double worst() const { return worst_; }

 private:
  const std::vector<Point>& points_;
  std::vector<double> at_;
  std::size_t last_ = 1;
  double worst_ = 0;
};

/// Largest first to third difference of each axis, the machine standing before and after.
class Differences {
 public:
  void add(const Point& q) {
    if (!begun_) last_[0] = q;
    begun_ = true;
    std::array<Point, 4> now{q};
    for (std::size_t n = 1; n <= 3; ++n)
      for (std::size_t i = 0; i < 3; ++i) {
        now[n][i] = (now[n - 1][i] - last_[n - 1][i]) / kTick;
        most_[n][i] = std::max(most_[n][i], std::abs(now[n][i]));
      }
    last_ = now;
  }
  void end() {
    for (int n = 0; n < 3; ++n) add(Point(last_[0]));
  }
  [[nodiscard]] std::string largest(std::size_t order, std::size_t axes) const {
    std::string out = "[";
    for (std::size_t i = 0; i < axes; ++i) {
      char text[40];
      std::snprintf(text, sizeof text, "%s%.6g", i > 0 ? ", " : "", most_[order][i]);
      out += text;
    }
    return out + "]";
  }

 private:
  bool begun_ = false;
  std::array<Point, 4> last_{}, most_{};  ///< by order
};

/// What is said of a path that takes too long; empty where it does not.
std::string too_long(double seconds) {
  if (seconds <= kMostSetpoints * kTick) return {};
  char text[200];
  std::snprintf(
      text, sizeof text,
      "the path takes %.3g s or more, that is %.3g setpoints of 1 ms; %.0e are the most: divide it, or give it "
      "higher limits",
      seconds, seconds / kTick, kMostSetpoints);
  return text;
}

int refuse(const std::string& file, const std::string& why, int status) {
  std::fprintf(stderr, "%s: %s\n", file.c_str(), why.c_str());
  return status;
}

int run(const Options& o) {
  if (std::filesystem::is_directory(o.file)) return refuse(o.file, "is a folder; expected a CSV file", 2);
  std::ifstream file(o.file);
  if (!file) return refuse(o.file, "cannot be read", 2);
  const Polyline polyline = read_polyline(file);
  if (!polyline.error.empty()) return refuse(o.file, polyline.error, 3);
  const double bound = bound_s(polyline.points, {o.v, o.a, o.speed, o.tolerance});
  if (const std::string why = too_long(bound); !why.empty()) return refuse(o.file, why, 4);
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(nullptr, &std::fclose);
  if (!o.setpoints.empty()) {
    out.reset(std::fopen(o.setpoints.c_str(), "w"));
    if (out == nullptr) return refuse(o.setpoints, "cannot be written", 2);
  }
  Result<Planned> planned = plan(o, polyline);
  for (int n = 1; n < o.runs && planned; ++n) {
    Result<Planned> again = plan(o, polyline);
    if (again && again->seconds < planned->seconds) planned = std::move(again);
  }
  if (!planned) return refuse(o.file, to_text(planned.error()), 4);
  double total = 0;
  for (const motion::Stretch& s : planned->stretches) total += s.duration_s;
  if (const std::string why = too_long(total); !why.empty()) return refuse(o.file, why, 4);

  Deviation deviation(polyline.points);
  Differences differences;
  if (out != nullptr) std::fputs("t,x,y,z\n", out.get());
  each_setpoint(*planned, polyline, [&](double t, const Point& q) {
    deviation.add(q);
    differences.add(q);
    if (out != nullptr) std::fprintf(out.get(), "%.17g,%.17g,%.17g,%.17g\n", t, q[0], q[1], q[2]);
  });
  differences.end();
  if (out != nullptr && (std::fflush(out.get()) != 0 || std::ferror(out.get()) != 0))
    return refuse(o.setpoints, "cannot be written to its end", 2);
  std::printf(
      "{\"total_s\": %.9g, \"v_max\": %s, \"a_max\": %s, \"j_max\": %s, \"deviation_mm\": %.6g, "
      "\"plan_us\": %.1f, \"bound_s\": %.9g}\n",
      total, differences.largest(1, polyline.axes).c_str(), differences.largest(2, polyline.axes).c_str(),
      differences.largest(3, polyline.axes).c_str(), deviation.worst(), planned->seconds * 1e6, bound);
  const auto& c = planned->counts;
  std::fprintf(stderr,
               "curves %zu, windows %zu, second tries %zu, cells %zu, steps %zu, most waiting %zu, forced rests %zu\n",
               c.curves, c.windows, c.second_tries, c.cells, c.steps, c.most_waiting, c.forced_rests);
  return 0;
}

/// A finite number above 0, or from 0 on.
CLI::Validator number(bool with_zero) {
  return CLI::Validator(
      [with_zero](const std::string& text) {
        char* end = nullptr;
        const double x = std::strtod(text.c_str(), &end);
        const bool fits = !text.empty() && *end == '\0' && std::isfinite(x) && (with_zero ? x >= 0 : x > 0);
        return fits ? std::string{} : text + " is not a number " + (with_zero ? "from 0 on" : "above 0");
      },
      with_zero ? "0 or more" : "above 0");
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  using gantry::bench::number;
  gantry::bench::Options o;
  CLI::App app{"plans a path along a polyline"};
  app.add_option("file", o.file, "CSV: header, then x,y[,z] in mm")->required();
  app.add_option("--v", o.v, "speed limit of each axis, mm/s")->check(number(false));
  app.add_option("--a", o.a, "acceleration limit of each axis, mm/s2")->check(number(false));
  app.add_option("--j", o.j, "jerk limit of each axis, mm/s3")->check(number(false));
  app.add_option("--tol", o.tolerance, "how far the path may leave the polyline, mm")->check(number(true));
  app.add_option("--speed", o.speed, "set speed of the tool, mm/s (default: what the axes allow)")
      ->check(number(false));
  app.add_option("--setpoints", o.setpoints, "file for the 1 ms setpoints");
  app.add_option("--runs", o.runs, "plan so often, tell the least time")->check(number(false));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  return gantry::bench::run(o);
}
