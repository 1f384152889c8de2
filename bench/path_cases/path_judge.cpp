// Judges setpoints against a polyline and shares nothing with the planner: reads both files, differentiates by
// differences, measures distances to all segments.
//   path_judge POLYLINE.csv SETPOINTS.csv --v 200 --a 3000 --j 50000 --tol 0.05
// One line of JSON; ends with 0 when all holds: limits x 1.01 with the machine standing before and after, every
// setpoint within the tolerance of the polyline, every point of the polyline within 1.5 times of it of the setpoints'
// path, start and end at rest on the first and last point, no standstill in between (unless --may-rest).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

namespace {

using Point = std::array<double, 3>;
using Path = std::vector<Point>;

double distance(const Point& q, const Point& a, const Point& b) {
  double ab = 0, aq = 0, sum = 0;
  for (int i = 0; i < 3; ++i) ab += (b[i] - a[i]) * (b[i] - a[i]), aq += (q[i] - a[i]) * (b[i] - a[i]);
  const double on = ab > 0 ? std::max(0.0, std::min(1.0, aq / ab)) : 0;
  for (int i = 0; i < 3; ++i) sum += std::pow(q[i] - a[i] - on * (b[i] - a[i]), 2);
  return std::sqrt(sum);
}

/// Segments of a path by the cells of a grid (x and y), so that a distance below `reach` is found exactly.
class Grid {
 public:
  Grid(const Path& path, double reach) : path_(path), size_(std::max(reach, 0.5)) {
    for (std::size_t k = 1; k < path.size(); ++k)
      for (long x = cell(std::min(path[k - 1][0], path[k][0])) - 1; x <= cell(std::max(path[k - 1][0], path[k][0])) + 1;
           ++x)
        for (long y = cell(std::min(path[k - 1][1], path[k][1])) - 1;
             y <= cell(std::max(path[k - 1][1], path[k][1])) + 1; ++y)
          cells_[{x, y}].push_back(k);
  }
  double nearest(const Point& q) const {
    double best = HUGE_VAL;
    const auto found = cells_.find({cell(q[0]), cell(q[1])});
    if (found != cells_.end())
      for (const std::size_t k : found->second) best = std::min(best, distance(q, path_[k - 1], path_[k]));
    return best;
  }

 private:
  long cell(double x) const { return static_cast<long>(std::floor(x / size_)); }
  const Path& path_;
  double size_;
  std::map<std::pair<long, long>, std::vector<std::size_t>> cells_;
};

std::vector<std::vector<double>> rows(const std::string& file) {
  std::vector<std::vector<double>> out;
  std::ifstream in(file);
  std::string line, cell;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    out.emplace_back();
    while (std::getline(cells, cell, ',')) out.back().push_back(std::stod(cell));
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::string polyline_file, setpoint_file;
  double v = 200, a = 3000, j = 50000, tolerance = 0.05;
  bool may_rest = false;
  CLI::App app{"judges setpoints against a polyline"};
  app.add_option("polyline", polyline_file)->required();
  app.add_option("setpoints", setpoint_file)->required();
  app.add_option("--v", v), app.add_option("--a", a), app.add_option("--j", j), app.add_option("--tol", tolerance);
  app.add_flag("--may-rest", may_rest, "standstills are no mistake");
  CLI11_PARSE(app, argc, argv);

  Path polyline, path;
  for (const auto& r : rows(polyline_file)) polyline.push_back({r[0], r[1], r.size() > 2 ? r[2] : 0});
  const auto setpoints = rows(setpoint_file);
  for (const auto& r : setpoints) path.push_back({r[1], r[2], r.size() > 3 ? r[3] : 0});
  std::string wrong;
  const double h = 0.001;
  for (std::size_t k = 0; k + 1 < setpoints.size(); ++k)
    if (std::abs(setpoints[k][0] - static_cast<double>(k) * h) > 1e-9) wrong = "times";

  // Differences, once with the resting position around, once without.
  double most[4] = {0, 0, 0, 0};
  for (const bool padded : {true, false})
    for (std::size_t i = 0; i < 3; ++i) {
      std::vector<double> x;
      if (padded) x.assign(4, path.front()[i]);
      for (const Point& p : path) x.push_back(p[i]);
      if (padded) x.insert(x.end(), 4, path.back()[i]);
      for (int order = 1; order <= 3; ++order) {
        for (std::size_t k = 0; k + 1 < x.size(); ++k) x[k] = (x[k + 1] - x[k]) / h;
        x.pop_back();
        for (const double y : x) most[order] = std::max(most[order], std::abs(y));
      }
    }
  if (most[1] > 1.01 * v || most[2] > 1.01 * a || most[3] > 1.01 * j) wrong += " limits";

  double off = 0, missed = 0;
  const Grid near_polyline(polyline, 2 * tolerance), near_path(path, 4 * tolerance);
  for (const Point& p : path) off = std::max(off, near_polyline.nearest(p));
  for (const Point& p : polyline) missed = std::max(missed, near_path.nearest(p));
  if (off > tolerance + 1e-6) wrong += " deviation";
  if (missed > 1.5 * tolerance + 0.02) wrong += " missed";  // chords of 1 ms cut corners themselves
  if (distance(path.front(), polyline.front(), polyline.front()) > 1e-9) wrong += " start";
  if (distance(path.back(), polyline.back(), polyline.back()) > 1e-9) wrong += " end";

  // A standstill: less than 1 nm in three ticks, away from the ends.
  std::size_t rests = 0;
  for (std::size_t k = 20; k + 20 < path.size(); ++k) rests += distance(path[k], path[k + 3], path[k + 3]) < 1e-6;
  if (rests > 0 && !may_rest) wrong += " standstill";
  std::printf(
      "{\"seconds\": %.6f, \"v\": %.4f, \"a\": %.4f, \"j\": %.4f, \"off_mm\": %.6f, \"missed_mm\": %.6f, "
      "\"rest_ticks\": %zu, \"wrong\": \"%s\"}\n",
      setpoints.back()[0], most[1] / v, most[2] / a, most[3] / j, off, missed, rests, wrong.c_str());
  return wrong.empty() ? 0 : 1;
}
