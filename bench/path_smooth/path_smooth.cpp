// Smooth curves with radii of at least a^3/j^2, in chords: how much longer does the plan take than a bound that is
// computed apart (curve_bound.hpp)? Only curves whose bound is 0.6 s or more count.
//   path_smooth [--curves 512] [--seed 1] [--dump DIR] [--optimum N]
// --optimum: how long the N worst take at least on the curves that were planned, with jerk (optimum.hpp).
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "bench/path_smooth/curve_bound.hpp"
#include "bench/path_smooth/optimum.hpp"
#include "bench/path_smooth/smooth_curve.hpp"
#include "motion/path/path_planner.hpp"

namespace gantry::bench {
namespace {

constexpr double kV = 200, kA = 3000, kJ = 50000, kTolerance = 0.05, kLeastBound_s = 0.6, kMost = 1.10;
constexpr double kLeastRadius_mm = kA * kA * kA / (kJ * kJ);

struct Row {
  std::uint64_t seed = 0;
  std::string kind;
  double seconds = 0, bound_s = 0;
  std::size_t forced_rests = 0;
  [[nodiscard]] double ratio() const { return seconds / bound_s; }
};

motion::Limits machine() {
  motion::Limits limits;
  limits.axes = 3;
  for (std::size_t i = 0; i < 3; ++i) limits.axis[i] = {-HUGE_VAL, HUGE_VAL, kV, kA, kJ}, limits.linear[i] = true;
  return limits;
}

/// Of no duration where it is not planned.
motion::Stretch planned(const std::vector<Point>& points, std::size_t& forced_rests) {
  motion::PathPlanner planner(machine(), {.tolerance_mm = kTolerance, .speed_mm_s = 2 * kV});
  for (const Point& p : points) {
    AxisVec q{};
    std::copy(p.begin(), p.end(), q.begin());
    if (!planner.add(q)) return {};
  }
  motion::Stretch out;
  if (planner.finish()) planner.take_all(out);
  forced_rests = planner.counts().forced_rests;
  return out;
}

double at_share(std::vector<double> sorted, double share) {
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

void tell(const std::string& name, const std::vector<Row>& rows) {
  std::vector<double> ratios;
  std::size_t over = 0;
  for (const Row& r : rows) ratios.push_back(r.ratio()), over += r.ratio() > kMost;
  std::printf("%-18s %4zu curves, ratio median %.3f, 90 %% %.3f, max %.3f, %zu above %.2f\n", name.c_str(), rows.size(),
              at_share(ratios, 0.5), at_share(ratios, 0.9), at_share(ratios, 1), over, kMost);
}

void dump(const std::string& folder, const Row& row, const std::vector<Point>& points) {
  std::FILE* out = std::fopen((folder + "/" + std::to_string(row.seed) + ".csv").c_str(), "w");
  if (out == nullptr) return;
  std::fputs("x,y,z\n", out);
  for (const Point& p : points) std::fprintf(out, "%.17g,%.17g,%.17g\n", p[0], p[1], p[2]);
  std::fclose(out);
}

int run(std::size_t curves, std::uint64_t seed, const std::string& folder, std::size_t optima) {
  std::vector<Row> rows;
  for (; rows.size() < curves; ++seed) {
    const SmoothCurve curve = draw_curve(seed, kLeastRadius_mm);
    Row row{seed, curve.kind, 0, bound_on_curve_s(curve.dense, {kV, kA}), 0};
    if (row.bound_s < kLeastBound_s) continue;
    row.seconds = planned(curve.chords, row.forced_rests).duration_s;
    if (!(row.seconds > 0)) row.seconds = HUGE_VAL;
    rows.push_back(row);
    if (row.ratio() > kMost && !folder.empty()) dump(folder, row, curve.chords);
  }
  std::map<std::string, std::vector<Row>> kinds;
  for (const Row& r : rows) kinds[r.kind].push_back(r);
  for (const auto& [kind, of_kind] : kinds) tell(kind, of_kind);
  tell("all", rows);
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.ratio() > b.ratio(); });
  for (std::size_t k = 0; k < std::min<std::size_t>(rows.size(), 10); ++k)
    std::printf("seed %lu, %s: %.3f s, bound %.3f s, ratio %.3f%s\n", rows[k].seed, rows[k].kind.c_str(),
                rows[k].seconds, rows[k].bound_s, rows[k].ratio(), rows[k].forced_rests > 0 ? ", forced rests" : "");
  for (std::size_t k = 0; k < std::min(rows.size(), optima); ++k) {
    const motion::Stretch plan = planned(draw_curve(rows[k].seed, kLeastRadius_mm).chords, rows[k].forced_rests);
    const double least = optimum_s(plan.curves, machine(), {}),
                 finer = optimum_s(plan.curves, machine(),
                                   {.speeds = 150, .accelerations = 151, .jerks = 31, .place_s = 0.003});
    std::printf("seed %lu: planned %.3f s, at least %.3f s (finer grid %.3f s), %.3f of the bound without jerk\n",
                rows[k].seed, rows[k].seconds, least, finer, finer / rows[k].bound_s);
  }
  return rows.front().ratio() > kMost ? 1 : 0;
}

}  // namespace
}  // namespace gantry::bench

int main(int argc, char** argv) {
  std::size_t curves = 512, optima = 0;
  std::uint64_t seed = 1;
  std::string folder;
  CLI::App app{"plans smooth curves and compares with a lower bound"};
  app.add_option("--curves", curves);
  app.add_option("--seed", seed, "of the first curve; the others follow");
  app.add_option("--dump", folder, "folder for polylines above 1.10");
  app.add_option("--optimum", optima, "of so many of the worst: the least time with jerk on the same curves");
  CLI11_PARSE(app, argc, argv);
  return gantry::bench::run(curves, seed, folder, optima);
}
