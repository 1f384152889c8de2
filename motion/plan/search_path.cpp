#include "motion/plan/search_path.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/units.hpp"
#include "motion/plan/askew_cells.hpp"
#include "motion/plan/join_paths.hpp"
#include "motion/plan/random_tree.hpp"
#include "motion/plan/shorten.hpp"

namespace gantry::motion {
namespace {

constexpr double kGoodEnough = 1.03;  // times the straight line: no shorter path is looked for

Vec3 position(const Scene& scene, const AxisVec& q) { return {q[scene.x()], q[scene.y()], q[scene.z()]}; }

/// Of Z, on a path between these.
double lowest(const Scene& scene, const Margins& margins, double start_mm, double goal_mm) {
  const double p_min = scene.axes()[scene.z()].p_min;
  return std::max(p_min, std::min({margins.lowest_mm.value_or(p_min), start_mm, goal_mm}));
}

/// Positions of the carrying axes while all others stand.
class Carried {
 public:
  Carried(const Scene& scene, const Margins& margins, const AxisVec& others)
      : scene_(scene), margins_(margins), others_(others) {}

  [[nodiscard]] AxisVec at(Vec3 p) const {
    AxisVec q = others_;
    q[scene_.x()] = p.x, q[scene_.y()] = p.y, q[scene_.z()] = p.z;
    return q;
  }
  [[nodiscard]] bool clear(Vec3 a, Vec3 b) const { return is_clear(scene_, at(a), at(b), margins_); }
  /// Of a path between these.
  [[nodiscard]] Vec3 low(Vec3 start, Vec3 goal) const {
    const auto& a = scene_.axes();
    return {a[scene_.x()].p_min, a[scene_.y()].p_min, lowest(scene_, margins_, start.z, goal.z)};
  }
  [[nodiscard]] Vec3 high() const {
    const auto& a = scene_.axes();
    return {a[scene_.x()].p_max, a[scene_.y()].p_max, a[scene_.z()].p_max};
  }
  [[nodiscard]] std::vector<KeptApart> pairs() const {
    std::vector<KeptApart> out;
    out.reserve(scene_.head().size() * scene_.standing().size());
    for (std::size_t i = 0; i < scene_.head().size(); ++i) {
      const SceneBody& body = scene_.head()[i];
      const Solid there = scene_.placed(body, at({}));
      for (std::size_t k = 0; k < scene_.standing().size(); ++k)
        out.push_back({difference(there, scene_.standing()[k].solid), margins_.of(i, k)});
    }
    return out;
  }

 private:
  const Scene& scene_;
  const Margins& margins_;
  AxisVec others_;
};

std::uint64_t seed_of(const Scene& scene, Vec3 from, Vec3 to) {
  std::uint64_t h = scene.hash_of_geometry();
  for (const double v : {from.x, from.y, from.z, to.x, to.y, to.z}) {
    h ^= std::bit_cast<std::uint64_t>(v + 0.0);
    h *= 0x9e3779b97f4a7c15ULL;
    h ^= h >> 29;
  }
  return h;
}

struct Best {
  Vec3 low, high;  ///< limits
  std::vector<Vec3> points;
  double length_mm = std::numeric_limits<double>::infinity();
  PathKind kind = PathKind::Detour;
  /// Taken when it is shorter, and clear in the direction in which it is gone: trees grow from both ends. What rounding
  /// takes beyond the limits comes back.
  void offer(std::vector<Vec3> other, PathKind of, const Clear& clear) {
    for (std::size_t i = 1; i + 1 < other.size(); ++i)
      other[i] = {std::clamp(other[i].x, low.x, high.x), std::clamp(other[i].y, low.y, high.y),
                  std::clamp(other[i].z, low.z, high.z)};
    if (other.empty() || length_of(other) >= length_mm) return;
    for (std::size_t i = 0; i + 1 < other.size(); ++i)
      if (!clear(other[i], other[i + 1])) return;
    points = std::move(other), length_mm = length_of(points), kind = of;
  }
};

/// The box about all points from which start and goal together are no farther than `length_mm`: an ellipsoid, whose
/// axis is their line (Gammell, Srinivasa, Barfoot 2014). Within `all`.
Box worth_looking(const Box& all, Vec3 start, Vec3 goal, double length_mm) {
  if (!std::isfinite(length_mm)) return all;
  const Vec3 line = goal - start, middle = (start + goal) * 0.5;
  const double square = dot(line, line), long_square = length_mm * length_mm / 4,
               short_square = std::max(0.0, length_mm * length_mm - square) / 4;
  const auto reach = [&](double along) {
    const double share = square > 0 ? along * along / square : 0;
    return std::sqrt(long_square * share + short_square * (1 - share));
  };
  const Vec3 half{reach(line.x), reach(line.y), reach(line.z)}, low = all.centre - all.half,
                                                                high = all.centre + all.half;
  const Vec3 from{std::max(low.x, middle.x - half.x), std::max(low.y, middle.y - half.y),
                  std::max(low.z, middle.z - half.z)};
  const Vec3 to{std::min(high.x, middle.x + half.x), std::min(high.y, middle.y + half.y),
                std::min(high.z, middle.z + half.z)};
  return {(from + to) * 0.5, (to - from) * 0.5};
}

}  // namespace

std::optional<std::size_t> beyond_limits(const Scene& scene, const AxisVec& q, double rounding) {
  for (std::size_t i = 0; i < scene.axes().size(); ++i) {
    const Scene::Axis& a = scene.axes()[i];
    if (!(q[i] >= a.p_min - rounding && q[i] <= a.p_max + rounding)) return i;
  }
  return std::nullopt;
}

SearchAnswer search_path(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                         const SearchBudget& budget) {
  SearchAnswer out;
  for (const bool start : {true, false}) {
    const AxisVec& end = start ? from : to;
    out.status = start ? SearchStatus::StartCollides : SearchStatus::GoalCollides;
    if (out.beyond = beyond_limits(scene, end); out.beyond) return out;
    if (out.hit = first_hit(scene, end, end, margins); out.hit) return out;
  }
  if (!is_clear(scene, from, to, margins)) {
    const auto over = lift_over(scene, from, to, margins);
    return search_around(scene, from, to, margins, budget, over ? &*over : nullptr);
  }
  out.status = SearchStatus::Ok;
  out.kind = from == to ? PathKind::Standstill : PathKind::Straight;
  out.length_mm = norm(position(scene, to) - position(scene, from)), out.points = {from, to};
  return out;
}

namespace {

/// Of C, tried where neither where it is nor where it is to be leads through: along the axes, and askew.
constexpr double kTurns_rad[] = {0,
                                 units::rad(90),
                                 units::rad(-90),
                                 units::rad(180),
                                 units::rad(-180),
                                 units::rad(45),
                                 units::rad(-45),
                                 units::rad(135),
                                 units::rad(-135)};

constexpr std::size_t kShare = 12;          // of all cuts one of these is made before slanted slots are looked for
constexpr std::size_t kMostDirections = 4;  // of which as many are made along each direction

/// Cells along the axes; where these find nothing soon, along faces that stand askew where they are stuck; then along
/// the axes until all cuts are made. `take(points)` says whether it is a path.
template <class Take>
CellAnswer search_cells(const std::vector<KeptApart>& pairs, const Cell& space, Vec3 start, Vec3 goal,
                        std::size_t most_cuts, const Take& take) {
  std::vector<CellPair> along_axes;
  along_axes.reserve(pairs.size());
  for (const KeptApart& p : pairs) along_axes.emplace_back(p.difference, p.margin_mm);
  CellSearch cells(std::move(along_axes), space);
  CellAnswer answer = cells.search(start, goal, most_cuts / kShare);
  if (answer.kind == CellAnswer::Kind::Undecided && space.low[0] < space.high[0] && space.low[1] < space.high[1]) {
    std::vector<Vec2> directions = cells.askew();
    directions.resize(std::min(directions.size(), kMostDirections));
    for (const Vec2 x : directions) {
      auto points = path_along(pairs, space, x, start, goal, most_cuts / kShare);
      if (!points.empty() && take(std::move(points))) return answer;
    }
  }
  if (answer.kind == CellAnswer::Kind::Undecided) answer = cells.search(start, goal, most_cuts);
  if (answer.kind == CellAnswer::Kind::Path && !take(std::move(answer.points)))
    answer.kind = CellAnswer::Kind::Undecided;
  return answer;
}

/// A path of X, Y and Z is looked for while all other axes stand as `others` has them.
SearchAnswer search_standing(const Scene& scene, const AxisVec& from, const AxisVec& to, const AxisVec& others,
                             const Margins& margins, const SearchBudget& budget, const LiftOver* over) {
  SearchAnswer out;
  out.status = SearchStatus::Ok;
  const Carried carried(scene, margins, others);
  const Vec3 start = position(scene, from), goal = position(scene, to);
  const auto finish = [&](const std::vector<Vec3>& points, PathKind kind) {
    out.kind = kind, out.length_mm = length_of(points);
    out.points = {from};
    for (const Vec3 p : points)
      if (carried.at(p) != out.points.back()) out.points.push_back(carried.at(p));
    if (out.points.back() != to) out.points.push_back(to);
    if (out.points.size() == 1) out.points.push_back(to), out.kind = PathKind::Standstill;
    return out;
  };
  // The other axes go where they stay before X, Y and Z move, and where they end after that.
  if (!is_clear(scene, from, carried.at(start), margins) || !is_clear(scene, carried.at(goal), to, margins)) {
    out.status = SearchStatus::Budget;
    return out;
  }

  const Clear clear = [&](Vec3 a, Vec3 b) { return carried.clear(a, b); };
  const Vec3 low = carried.low(start, goal), high = carried.high();
  Best best{low, high, {}};
  if (over != nullptr) {
    std::vector<Vec3> points;
    for (const AxisVec& q : over->points)
      if (const Vec3 p = position(scene, q); points.empty() || p != points.back()) points.push_back(p);
    shorten(points, clear);
    best.offer(std::move(points), PathKind::LiftOver, clear);
  }
  const Box all{(low + high) * 0.5, (high - low) * 0.5};
  std::vector<std::vector<Vec3>> found;
  for (int n = 0; n < budget.random_trees && best.length_mm > kGoodEnough * norm(goal - start); ++n) {
    const Box where = worth_looking(all, start, goal, best.length_mm);
    auto tree = random_tree(clear, where.centre - where.half, where.centre + where.half, start, goal,
                            seed_of(scene, start, goal) + static_cast<std::uint64_t>(n), budget.random_iterations);
    if (tree.empty()) continue;
    leave_out(tree, clear);
    found.push_back(tree);
    shorten(tree, clear);
    best.offer(std::move(tree), PathKind::Detour, clear);
  }
  if (found.size() > 1) {
    auto joined = join_paths(found, clear);
    shorten(joined, clear);
    best.offer(std::move(joined), PathKind::Detour, clear);
  }
  if (!best.points.empty()) return finish(best.points, best.kind);

  const CellAnswer answer = search_cells(carried.pairs(), {{low.x, low.y, low.z}, {high.x, high.y, high.z}}, start,
                                         goal, budget.cuts, [&](std::vector<Vec3> points) {
                                           shorten(points, clear);
                                           best.offer(std::move(points), PathKind::Detour, clear);
                                           return !best.points.empty();
                                         });
  out.cuts = answer.cuts;
  if (!best.points.empty()) return finish(best.points, best.kind);
  out.closed_in = answer.closed_in;
  out.status = answer.kind == CellAnswer::Kind::NoPath ? SearchStatus::NoPath : SearchStatus::Budget;
  return out;
}

// As many iterations for each of those without a turn: most of them fail, and at once.
constexpr int kTurningTries = 20;

/// C turns on the way: a random tree over X, Y, Z and C, of which corners are left out.
SearchAnswer search_turning(const Scene& scene, const AxisVec& from, const AxisVec& to, const AxisVec& others,
                            const Margins& margins, const SearchBudget& budget) {
  SearchAnswer out;
  const auto& axes = scene.axes();
  double per_rad = 0;
  for (const SceneBody& body : scene.head()) per_rad = std::max(per_rad, body.turning_mm);
  const std::array<std::size_t, 4> of{scene.x(), scene.y(), scene.z(), scene.c()};
  const auto scaled = [&](const AxisVec& q) { return Turned{q[of[0]], q[of[1]], q[of[2]], q[of[3]] * per_rad}; };
  const auto at = [&](const Turned& p) {
    AxisVec q = others;
    for (std::size_t i = 0; i < 4; ++i)
      q[of[i]] = std::clamp(p[i] / (i == 3 ? per_rad : 1), axes[of[i]].p_min, axes[of[i]].p_max);
    return q;
  };
  AxisVec low{}, high{};
  for (const std::size_t axis : of) low[axis] = axes[axis].p_min, high[axis] = axes[axis].p_max;
  low[scene.z()] = lowest(scene, margins, from[scene.z()], to[scene.z()]);
  const AxisVec start = at(scaled(from)), goal = at(scaled(to));
  const auto clear = [&](const AxisVec& a, const AxisVec& b) { return is_clear(scene, a, b, margins); };
  if (!clear(from, start) || !clear(goal, to)) return out;
  const ClearTurned clear_turned = [&](const Turned& a, const Turned& b) { return clear(at(a), at(b)); };
  for (int n = 0; n < budget.random_trees; ++n) {
    const std::uint64_t seed = seed_of(scene, position(scene, from), position(scene, to)) +
                               static_cast<std::uint64_t>(n) + std::bit_cast<std::uint64_t>(to[of[3]] - from[of[3]]);
    const auto tree = random_turning_tree(clear_turned, scaled(low), scaled(high), scaled(start), scaled(goal), seed,
                                          budget.random_iterations * kTurningTries);
    if (tree.empty()) continue;
    std::vector<AxisVec> points{from};
    for (const Turned& p : tree) points.push_back(at(p));
    points.push_back(to);
    std::vector<AxisVec> kept{from};
    for (std::size_t i = 0; i + 1 < points.size();) {
      std::size_t next = points.size() - 1;
      while (next > i + 1 && !clear(points[i], points[next])) --next;
      if (points[next] != kept.back()) kept.push_back(points[next]);
      i = next;
    }
    double length_mm = 0;
    bool free = true;  // in the direction in which it is gone: trees grow from both ends
    for (std::size_t i = 0; i + 1 < kept.size(); ++i) {
      length_mm += norm(position(scene, kept[i + 1]) - position(scene, kept[i]));
      free = free && clear(kept[i], kept[i + 1]);
    }
    if (!free || (out.status == SearchStatus::Ok && length_mm >= out.length_mm)) continue;
    out.status = SearchStatus::Ok, out.kind = PathKind::Detour;
    out.points = std::move(kept), out.length_mm = length_mm;
  }
  return out;
}

}  // namespace

SearchAnswer search_around(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                           const SearchBudget& budget, const LiftOver* over) {
  AxisVec others = from;
  if (scene.has_lift()) others[scene.u()] = std::min(from[scene.u()], to[scene.u()]);
  if (!scene.turns()) return search_standing(scene, from, to, others, margins, budget, over);
  // C turns before the path, or after it, or both, for a position in which it is gone; else on it. That there is no
  // path is only proved for one position of C.
  SearchAnswer best;
  const std::size_t c = scene.c();
  const Scene::Axis& axis = scene.axes()[c];
  std::vector<double> turns{from[c], to[c]};
  for (const double turn : kTurns_rad)
    if (turn >= axis.p_min && turn <= axis.p_max && turn != from[c] && turn != to[c]) turns.push_back(turn);
  for (std::size_t i = from[c] == to[c] ? 1 : 0; i < turns.size(); ++i) {
    if (i >= 2 && best.status == SearchStatus::Ok) break;
    others[c] = turns[i];
    SearchAnswer found = search_standing(scene, from, to, others, margins, budget, nullptr);
    if (found.status != SearchStatus::Ok) continue;
    if (best.status != SearchStatus::Ok || found.length_mm < best.length_mm) best = std::move(found);
  }
  if (best.status != SearchStatus::Ok) best = search_turning(scene, from, to, others, margins, budget);
  double over_mm = 0;
  for (std::size_t i = 0; over != nullptr && i + 1 < over->points.size(); ++i)
    over_mm += norm(position(scene, over->points[i + 1]) - position(scene, over->points[i]));
  if (over == nullptr || (best.status == SearchStatus::Ok && best.length_mm <= over_mm)) return best;
  best.status = SearchStatus::Ok, best.kind = PathKind::LiftOver;
  best.points = over->points, best.length_mm = over_mm;
  return best;
}

}  // namespace gantry::motion
