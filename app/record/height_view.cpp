// Height of the tool over time: in one row, or of a long job in several below each other, so that a dot can be seen in
// each of them.
#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "app/record/plot_axes.hpp"
#include "app/record/polyline.hpp"
#include "app/record/report_geometry.hpp"
#include "app/record/report_plots.hpp"
#include "app/record/summary.hpp"
#include "app/record/svg.hpp"

namespace gantry::record {
namespace {

constexpr double kWidth = 1000;
constexpr double kRow_s = 120, kMostRows = 16;  // a row is this long, but no more of them are drawn

/// The planned path's own time -> time of the actual path: each block begins where it was begun.
Path aligned(const JobResult& r) {
  std::map<std::uint32_t, double> begins;
  for (const auto& p : r.actual) begins.try_emplace(p.block, p.t_s);
  auto planned = r.planned;
  double shift = 0;
  std::uint32_t block = 0;
  for (auto& p : planned) {
    if (p.block != block) {
      const auto begun = begins.find(p.block);
      if (begun != begins.end()) shift = begun->second - p.t_s;
      block = p.block;
    }
    p.t_s += shift;
  }
  return planned;
}

/// What is drawn of a path: one point a moment, height over the board.
struct Moment {
  double t_s, z;
  std::uint32_t block;
  bool valve;
};
std::vector<Moment> moments(const JobResult& r, const Path& path) {
  std::vector<Moment> out;
  out.reserve(path.size());
  for (const PathPoint& p : path)
    if (const double z = tip_at(r, p).z; std::isfinite(z) && std::isfinite(p.t_s))
      out.push_back({p.t_s, z, p.block, p.valve});
  return out;
}

/// Those of [from, to], and a neighbour on each side, so that lines leave the row.
std::span<const Moment> within(const std::vector<Moment>& all, double from_s, double to_s) {
  const auto early = [](const Moment& m, double t) { return m.t_s < t; };
  auto first = std::lower_bound(all.begin(), all.end(), from_s, early);
  auto last = std::lower_bound(first, all.end(), to_s, early);
  if (first != all.begin()) --first;
  if (last != all.end()) ++last;
  return {first, last};
}

/// Bands behind the line. What is too near to be seen apart is one.
void draw_valve(Svg& svg, const Axes& a, std::span<const Moment> path) {
  std::vector<Vec2> bands;  // from, to
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!path[i].valve) continue;
    std::size_t j = i;
    while (j + 1 < path.size() && path[j].valve) ++j;
    const double from = std::max(a.px(path[i].t_s, 0).x, a.left), to = std::min(a.px(path[j].t_s, 0).x, a.right);
    if (bands.empty() || from > bands.back().y + 0.5)
      bands.push_back({from, to});
    else
      bands.back().y = to;
    i = j;
  }
  for (const Vec2 band : bands)
    svg.rect({band.x, a.top}, {std::max(0.6, band.y - band.x), a.bottom - a.top}, "valve-band");
}

void draw_line(Svg& svg, const Axes& a, std::span<const Moment> path, const char* css) {
  std::vector<Vec2> points;
  std::uint32_t block = 0;
  for (const Moment& m : path) {
    // Another block is another tool, whose tip is elsewhere: the line begins anew.
    if (m.block != block) svg.path(envelope(points), css), points.clear();
    block = m.block;
    points.push_back(a.px(m.t_s, m.z));
  }
  svg.path(envelope(points), css);
}

}  // namespace

std::string height_view(const JobResult& r) {
  if (r.actual.empty() && r.planned.empty()) return {};
  const std::vector<Moment> planned = moments(r, aligned(r)), actual = moments(r, r.actual);
  Axes a;
  a.y0 = 0, a.y1 = 10;
  double ends_s = 1e-3;
  for (const auto* path : {&planned, &actual})
    for (const Moment& m : *path)
      a.y0 = std::min(a.y0, m.z), a.y1 = std::max(a.y1, m.z), ends_s = std::max(ends_s, m.t_s);
  const double rows = std::clamp(std::ceil(ends_s / kRow_s - 0.25), 1.0, kMostRows), row_s = ends_s / rows;
  const double height = rows > 1 ? 130 : 190, pitch = height + 34;
  Svg svg(kWidth, 10 + rows * pitch, "height of the tool over time");
  const double step_y = round_step(a.y1 - a.y0, rows > 1 ? 3 : 5), step_x = round_step(row_s, 12);
  for (int row = 0; row < static_cast<int>(rows); ++row) {
    a.x0 = row * row_s, a.x1 = a.x0 + row_s;
    a.top = 10 + row * pitch, a.bottom = a.top + height;
    for (double y = std::ceil(a.y0 / step_y) * step_y; y <= a.y1; y += step_y) {
      svg.line(a.px(a.x0, y), a.px(a.x1, y), y == 0 ? "grid zero" : "grid");
      svg.words(a.px(a.x0, y) + Vec2{-6, 4}, html::number(y, 0), tick_css(y / step_y, "beside"), "end");
    }
    for (double x = std::ceil(a.x0 / step_x - 1e-9) * step_x; x <= a.x1 + 1e-9; x += step_x)
      svg.words_below({a.px(x, 0).x, a.bottom + 18}, html::number(x, step_x < 1 ? 1 : 0) + " s",
                      tick_css(x / step_x, "below"));
    svg.begin_clip({a.left, a.top}, {a.right - a.left, height}, "row" + std::to_string(row));
    draw_valve(svg, a, within(actual, a.x0, a.x1));
    draw_line(svg, a, within(planned, a.x0, a.x1), "planned");
    draw_line(svg, a, within(actual, a.x0, a.x1), "actual");
    for (const auto& c : r.collisions)
      if (c.t_s >= a.x0 && c.t_s <= a.x1) svg.line(a.px(c.t_s, a.y0), a.px(c.t_s, a.y1), "hit");
    if (ended_early(r) && !actual.empty() && actual.back().t_s >= a.x0 && actual.back().t_s <= a.x1)
      svg.line(a.px(actual.back().t_s, a.y0), a.px(actual.back().t_s, a.y1), "stopped");
    svg.end_clip();
  }
  return svg.done();
}

}  // namespace gantry::record
