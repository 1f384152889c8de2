#include "sim/world/deposits.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "core/new_file.hpp"

namespace gantry::sim {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
Vec2 flat(Vec3 p) { return {p.x, p.y}; }
Vec2 flat(Vec2 p) { return p; }

double distance_to_segment(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 ab = b - a;
  const double length2 = dot(ab, ab);
  const double t = length2 > 0 ? std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
  return norm(p - (a + ab * t));
}

template <class Point>
double distance_to_line(Vec2 p, std::span<const Point> line) {
  if (line.size() == 1) return norm(p - flat(line[0]));
  double best = kFar;
  for (std::size_t i = 1; i < line.size(); ++i)
    best = std::min(best, distance_to_segment(p, flat(line[i - 1]), flat(line[i])));
  return best;
}

double extent(const Shot& shot) {
  double out = 0;
  for (const Vec3& p : shot.path) out = std::max(out, norm(flat(p) - flat(shot.path.front())));
  return out;
}

/// How badly a shot fits a feature: where it begins, and how far it strays. A bead that was cut short fits its own.
double misfit(const Shot& shot, const BoardPlan::Feature& feature, double at_most) {
  const std::span<const Vec2> line(feature.points);
  double worst = norm(flat(shot.path.front()) - line.front());
  for (std::size_t i = 0; i < shot.path.size() && worst <= at_most; ++i)
    worst = std::max(worst, distance_to_line(flat(shot.path[i]), line));
  return worst;
}

struct Match {
  int feature = -1;
  double misfit = kFar;
};

/// A shot's own kind decides between features that fit equally well (a dot on the start of a bead).
constexpr double kWrongKind_mm = 0.05;
/// A free feature this much farther away than one that is taken is not meant: the shot is a second one on the same.
constexpr double kSecondShot_mm = 0.2;

/// The better fit; of equal ones the first in the recipe.
void keep_better(Match& best, int feature, double misfit) {
  if (misfit < best.misfit || (misfit == best.misfit && feature < best.feature)) best = {feature, misfit};
}

Match match(const BoardPlan& plan, const Starts& starts, const Shot& shot, const std::vector<bool>& taken) {
  const bool moved = extent(shot) > kDotExtent_mm;
  const Vec2 begin = flat(shot.path.front());
  Match free, any;
  starts.nearest_first(begin, kMatch_mm, [&](std::size_t i, double at_least_mm) {
    if (at_least_mm > free.misfit) return false;  // nothing fits better than it begins
    const BoardPlan::Feature& f = plan.features[i];
    if (norm(begin - f.points.front()) > kMatch_mm) return true;
    double fit = misfit(shot, f, kMatch_mm);
    if (fit > kMatch_mm) return true;
    if (f.bead != moved) fit += kWrongKind_mm;
    keep_better(any, static_cast<int>(i), fit);
    if (!taken[i]) keep_better(free, static_cast<int>(i), fit);
    return true;
  });
  if (free.feature >= 0 && free.misfit > any.misfit + kSecondShot_mm) return {};
  return free;
}

Deposit deposit_of(const Shot& shot) {
  Deposit d;
  d.kind = extent(shot) > kDotExtent_mm ? "bead" : "dot";
  d.board_mm = shot.path;
  d.opened_cycle = shot.opened_cycle;
  d.closed_cycle = shot.closed_cycle;
  d.gap_mm = shot.path.front().z;
  return d;
}

std::string text(std::span<const Vec3> points) {
  std::string out;
  for (const Vec3& p : points) out += fmt::format("{}{:.6f} {:.6f} {:.6f}", out.empty() ? "" : ";", p.x, p.y, p.z);
  return out;
}

}  // namespace

double path_error(std::span<const Vec3> path, std::span<const Vec2> nominal) {
  double worst = std::max(norm(flat(path.front()) - nominal.front()), norm(flat(path.back()) - nominal.back()));
  for (const Vec3& p : path) worst = std::max(worst, distance_to_line(flat(p), nominal));
  for (const Vec2& corner : nominal) worst = std::max(worst, distance_to_line(corner, path));
  return worst;
}

std::vector<Deposit> judge(const BoardPlan& plan, std::span<const std::shared_ptr<const Shot>> shots) {
  std::vector<bool> taken(plan.features.size(), false);
  const Starts starts = starts_of(plan);
  std::vector<Deposit> out;
  for (const auto& shot : shots) {
    if (shot->path.empty()) continue;
    Deposit d = deposit_of(*shot);
    if (const Match m = match(plan, starts, *shot, taken); m.feature >= 0) {
      const BoardPlan::Feature& f = plan.features[static_cast<std::size_t>(m.feature)];
      taken[static_cast<std::size_t>(m.feature)] = true;
      d.id = f.id;
      d.kind = f.bead ? "bead" : "dot";
      for (const Vec2& p : f.points) d.nominal_mm.push_back({p.x, p.y, f.gap_mm});
      d.error_mm = path_error(shot->path, f.points);
      for (const Vec3& p : shot->path)
        if (std::abs(p.z - f.gap_mm) > std::abs(d.gap_mm - f.gap_mm)) d.gap_mm = p.z;
    }
    if (d.kind == "dot") d.board_mm.resize(1);
    out.push_back(std::move(d));
  }
  return out;
}

int feature_begun(const BoardPlan& plan, const Starts& starts, Vec2 at) {
  Match best{-1, kMatch_mm};
  starts.nearest_first(at, kMatch_mm, [&](std::size_t i, double at_least_mm) {
    if (at_least_mm > best.misfit) return false;
    keep_better(best, static_cast<int>(i), norm(at - plan.features[i].points.front()));
    return true;
  });
  return best.feature;
}

Result<void> write_csv(std::span<const Deposit> deposits, const std::string& path) {
  std::string csv = "id,kind,opened_cycle,closed_cycle,error_mm,gap_mm,nominal_mm,board_mm\n";
  for (const Deposit& d : deposits) {
    // Ids are the recipe's and may hold a comma or a quote: RFC 4180, 2.6 and 2.7.
    std::string id = d.id;
    for (std::size_t at = 0; (at = id.find('"', at)) != std::string::npos; at += 2) id.insert(at, 1, '"');
    const std::string error = std::isfinite(d.error_mm) ? fmt::format("{:.6f}", d.error_mm) : std::string();
    csv += fmt::format("\"{}\",{},{},{},{},{:.6f},{},{}\n", id, d.kind, d.opened_cycle, d.closed_cycle, error, d.gap_mm,
                       text(d.nominal_mm), text(d.board_mm));
  }
  return write_new_file(path, csv);
}

}  // namespace gantry::sim
