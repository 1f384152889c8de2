#include "recipes/fill.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <optional>

namespace gantry::recipes {
namespace {

constexpr double kSlack = 1e-9;        // of the spacing: a line may lie at its distance from the outline
constexpr double kShortest_mm = 0.01;  // a shorter stretch of line is left out
constexpr double kContact_mm = 1e-9;   // edges that are nearer touch

struct Stretch {
  double from = 0, to = 0;
};

/// Edge k of the outline: from corner k to the next.
struct Edge {
  Vec2 a, b;
};
Edge edge(const std::vector<Vec2>& outline, std::size_t k) { return {outline[k], outline[(k + 1) % outline.size()]}; }

double distance(Vec2 p, Edge e) {
  const Vec2 along = e.b - e.a;
  const double length2 = dot(along, along);
  const double t = length2 > 0 ? std::clamp(dot(p - e.a, along) / length2, 0.0, 1.0) : 0.0;
  return norm(p - (e.a + along * t));
}

bool cross_each_other(Edge p, Edge q) {
  const auto side = [](Edge e, Vec2 at) { return cross(e.b - e.a, at - e.a); };
  return side(p, q.a) * side(p, q.b) < 0 && side(q, p.a) * side(q, p.b) < 0;
}

/// 0 where they cross.
double distance(Edge p, Edge q) {
  if (cross_each_other(p, q)) return 0;
  return std::min({distance(p.a, q), distance(p.b, q), distance(q.a, p), distance(q.b, p)});
}

/// An outline that goes back on itself or comes near to itself elsewhere encloses nothing one could name.
Result<void> simple(const std::vector<Vec2>& outline) {
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t after = (i + 1) % n;
    const Vec2 d = outline[after] - outline[i], e = outline[(i + 2) % n] - outline[after];
    if (norm(d) < kContact_mm)
      return fail(Fault::Inconsistent,
                  fmt::format("corners {} and {} of the outline are the same point", i + 1, after + 1));
    if (std::abs(cross(d, e)) < 1e-9 * norm(d) * norm(e) && dot(d, e) < 0)
      return fail(Fault::Inconsistent, fmt::format("the outline goes back on itself at corner {}", after + 1));
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = i + 2; k < n; ++k) {
      if (i == 0 && k == n - 1) continue;  // they share a corner
      if (distance(edge(outline, i), edge(outline, k)) < kContact_mm)
        return fail(
            Fault::Inconsistent,
            fmt::format("the outline crosses itself: its edges from corner {} and from corner {} meet", i + 1, k + 1));
    }
  return {};
}

double area(const std::vector<Vec2>& outline) {
  double twice = 0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Edge e = edge(outline, k);
    twice += cross(e.a - outline[0], e.b - outline[0]);
  }
  return std::abs(twice) / 2;
}

/// Where the level line at y is within the outline, from left to right.
std::vector<Stretch> inside(const std::vector<Vec2>& outline, double y) {
  std::vector<double> x;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Edge e = edge(outline, k);
    if ((e.a.y <= y) != (e.b.y <= y)) x.push_back(e.a.x + (y - e.a.y) / (e.b.y - e.a.y) * (e.b.x - e.a.x));
  }
  std::sort(x.begin(), x.end());
  std::vector<Stretch> out;
  for (std::size_t i = 0; i + 1 < x.size(); i += 2) out.push_back({x[i], x[i + 1]});
  return out;
}

/// Where the level line at y is nearer to an edge than d: what is so near is convex, so that this is one stretch.
std::optional<Stretch> near(Edge e, double y, double d) {
  if (y < std::min(e.a.y, e.b.y) - d || y > std::max(e.a.y, e.b.y) + d) return std::nullopt;
  Stretch out{INFINITY, -INFINITY};
  const auto take = [&](double x) { out = {std::min(out.from, x), std::max(out.to, x)}; };
  for (const Vec2 end : {e.a, e.b})
    if (const double up = y - end.y; std::abs(up) < d) {
      const double half = std::sqrt(d * d - up * up);
      take(end.x - half), take(end.x + half);
    }
  const Vec2 along = (e.b - e.a) * (1 / norm(e.b - e.a)), aside{-along.y * d, along.x * d};
  const std::array corners{e.a + aside, e.b + aside, e.b - aside, e.a - aside};
  for (std::size_t k = 0; k < 4; ++k) {
    const Edge side{corners[k], corners[(k + 1) % 4]};
    if ((side.a.y <= y) != (side.b.y <= y))
      take(side.a.x + (y - side.a.y) / (side.b.y - side.a.y) * (side.b.x - side.a.x));
  }
  if (out.from >= out.to) return std::nullopt;
  return out;
}

std::vector<Stretch> without(const std::vector<Stretch>& from, Stretch gap) {
  std::vector<Stretch> out;
  for (const Stretch s : from) {
    if (gap.to <= s.from || gap.from >= s.to) {
      out.push_back(s);
      continue;
    }
    if (gap.from > s.from) out.push_back({s.from, gap.from});
    if (gap.to < s.to) out.push_back({gap.to, s.to});
  }
  return out;
}

/// What a line at y may cover: within the outline, and d from each of its edges.
std::vector<Stretch> line_at(const std::vector<Vec2>& outline, double y, double d) {
  std::vector<Stretch> out = inside(outline, y);
  for (std::size_t k = 0; k < outline.size() && !out.empty(); ++k)
    if (const auto gap = near(edge(outline, k), y, d)) out = without(out, *gap);
  std::erase_if(out, [](Stretch s) { return s.to - s.from < kShortest_mm; });
  return out;
}

/// Lines of a fill, the k-th at first + k * spacing.
struct Rows {
  double first = 0, spacing = 0;
  std::vector<std::vector<Stretch>> lines;

  [[nodiscard]] std::size_t nearest(double y) const {
    return static_cast<std::size_t>(
        std::clamp(std::round((y - first) / spacing), 0.0, static_cast<double>(lines.size() - 1)));
  }
  [[nodiscard]] double y(std::size_t k) const { return first + static_cast<double>(k) * spacing; }
  /// For each line the next one above and below it that covers something; lines.size() where there is none.
  std::vector<std::size_t> above{}, below{};
  void link() {
    const std::size_t none = lines.size();
    above.assign(none, none), below.assign(none, none);
    for (std::size_t k = 1; k < none; ++k) below[k] = lines[k - 1].empty() ? below[k - 1] : k - 1;
    for (std::size_t k = none; k-- > 1;) above[k - 1] = lines[k].empty() ? above[k] : k;
  }
  /// From the nearest of them; where that is no more than `least`, some distance that is no more.
  [[nodiscard]] double distance(Vec2 p, double least) const {
    const std::size_t middle = nearest(p.y);
    double best = INFINITY;
    const auto look = [&](std::size_t k) {
      for (const Stretch s : lines[k])
        best = std::min(best, std::hypot(p.x - std::clamp(p.x, s.from, s.to), p.y - y(k)));
    };
    look(middle);
    for (const auto* next : {&above, &below})
      for (std::size_t k = (*next)[middle]; k < lines.size() && best > least && std::abs(y(k) - p.y) < best;
           k = (*next)[k])
        look(k);
    return best;
  }
};

/// By level lines a quarter of a spacing apart.
Bare bare_of(const std::vector<Vec2>& outline, const Rows& rows, double low, double high, double area_mm2) {
  constexpr double kOfSpacing = 4;
  const double half = rows.spacing / 2 * (1 + kSlack),
               looks = std::ceil((high - low) / rows.spacing * kOfSpacing * (1 - kSlack));
  const double step = (high - low) / looks;
  Bare out;
  for (int i = 0; i < static_cast<int>(looks); ++i) {
    const double y = low + (i + 0.5) * step;
    const std::size_t k = rows.nearest(y);
    std::vector<Stretch> bare = inside(outline, y);
    if (std::abs(y - rows.y(k)) <= half)
      for (const Stretch s : rows.lines[k]) bare = without(bare, {s.from - half, s.to + half});
    for (const Stretch s : bare) {
      out.share += (s.to - s.from) * step / area_mm2;
      for (const double x : {s.from, (s.from + s.to) / 2, s.to})
        if (const double mm = rows.distance({x, y}, out.farthest_mm); mm > out.farthest_mm)
          out.farthest_mm = mm, out.at = {x, y};
    }
  }
  return out;
}

bool free(const std::vector<Vec2>& outline, Edge leg, double d) {
  for (std::size_t k = 0; k < outline.size(); ++k)
    if (distance(leg, edge(outline, k)) < d) return false;
  return true;
}

/// Lines from the lowest up, joined to runs. A run goes on with the stretch of the next line that can be come to from
/// where it stands.
class Joiner {
 public:
  Joiner(const std::vector<Vec2>& outline, double keep_mm, bool serpentine)
      : outline_(outline), keep_mm_(keep_mm), serpentine_(serpentine) {}

  void line(double y, std::vector<Stretch> stretches) {
    std::vector<Open> next;
    for (const Open& run : open_) {
      const auto fits = [&](Stretch s) {
        const Vec2 to{run.rightwards ? s.to : s.from, y};
        return free(outline_, {runs_[run.index].back(), to}, keep_mm_);
      };
      const auto found = std::find_if(stretches.begin(), stretches.end(), fits);
      if (found == stretches.end()) continue;
      add(run.index, *found, y, !run.rightwards);
      next.push_back({run.index, !run.rightwards});
      stretches.erase(found);
    }
    for (const Stretch s : stretches) {
      runs_.emplace_back();
      add(runs_.size() - 1, s, y, true);
      next.push_back({runs_.size() - 1, true});
    }
    if (serpentine_) open_ = std::move(next);
  }
  [[nodiscard]] std::size_t points() const { return points_; }
  [[nodiscard]] std::vector<std::vector<Vec2>> runs() && { return std::move(runs_); }

 private:
  struct Open {
    std::size_t index = 0;
    bool rightwards = true;  ///< its last line
  };
  void add(std::size_t run, Stretch s, double y, bool rightwards) {
    runs_[run].push_back({rightwards ? s.from : s.to, y});
    runs_[run].push_back({rightwards ? s.to : s.from, y});
    points_ += 2;
  }

  const std::vector<Vec2>& outline_;
  double keep_mm_;
  bool serpentine_;
  std::vector<std::vector<Vec2>> runs_;
  std::vector<Open> open_;
  std::size_t points_ = 0;
};

}  // namespace

Result<FilledArea> fill_area(const std::vector<Vec2>& outline, const FillLines& lines, std::size_t most) {
  if (outline.size() < 3) return fail(Fault::Inconsistent, "an outline has three corners or more");
  if (auto ok = simple(outline); !ok) return tl::unexpected(ok.error());
  std::vector<Vec2> level;  // the outline, turned so that the lines run along X
  for (const Vec2 p : outline) level.push_back(rotated(p, -lines.angle_rad));
  const auto [low, high] = std::minmax_element(level.begin(), level.end(), [](Vec2 a, Vec2 b) { return a.y < b.y; });
  const double spacing_mm = lines.spacing_mm, across = high->y - low->y;
  const double count = std::floor(across / spacing_mm * (1 + kSlack));
  if (count < 1)
    return fail(Fault::Inconsistent,
                fmt::format("the area is {:.6g} mm across its lines, less than their spacing of {:.6g} mm; lower "
                            "'spacing', or turn the lines by 'angle'",
                            across, spacing_mm));
  const auto too_many = [most] {
    return fail(Fault::TooManySteps,
                fmt::format("the fill needs more than {} points; give it a larger 'spacing'", most));
  };
  if (!(2 * count <= static_cast<double>(most))) return too_many();
  const double first = low->y + (across - (count - 1) * spacing_mm) / 2, keep_mm = spacing_mm / 2;
  Rows rows{first, spacing_mm, {}};
  Joiner joiner(level, keep_mm * (1 - 1e-6), lines.serpentine);
  for (int k = 0; k < static_cast<int>(count); ++k) {
    const double y = first + k * spacing_mm;
    rows.lines.push_back(line_at(level, y, keep_mm * (1 - kSlack)));
    joiner.line(y, rows.lines.back());
    if (joiner.points() > most) return too_many();
  }
  FilledArea out{std::move(joiner).runs(), area(outline), {}};
  if (out.runs.empty())
    return fail(Fault::Inconsistent,
                fmt::format("the area is nowhere as wide as the spacing of {:.6g} mm; lower 'spacing'", spacing_mm));
  rows.link();
  out.bare = bare_of(level, rows, low->y, high->y, out.area_mm2);
  out.bare.at = rotated(out.bare.at, lines.angle_rad);
  for (auto& run : out.runs)
    for (Vec2& p : run) p = rotated(p, lines.angle_rad);
  return out;
}

}  // namespace gantry::recipes
