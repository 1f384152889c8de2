#include "app/record/report_plots.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "app/record/polyline.hpp"
#include "app/record/report_geometry.hpp"
#include "app/record/svg.hpp"

namespace gantry::record {
namespace {

constexpr double kWidth = 1000;

/// The planned path's own time -> time of the actual path: each block begins where it was begun.
std::vector<PathPoint> aligned(const JobResult& r) {
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

struct Axes {
  double left = 46, right = kWidth - 8, top = 10, bottom = 200;
  double x0 = 0, x1 = 1, y0 = 0, y1 = 1;
  [[nodiscard]] Vec2 px(double x, double y) const {
    return {left + (x - x0) / (x1 - x0) * (right - left), bottom - (y - y0) / (y1 - y0) * (bottom - top)};
  }
};

}  // namespace

double residual_magnification(const JobResult& r) {
  double worst = 0.002;  // what is smaller than 2 µm is not made to look large
  for (const auto& m : r.marks)
    if (m.found && std::isfinite(m.residual_mm)) worst = std::max(worst, std::abs(m.residual_mm));
  const double drawn_mm = 0.035 * std::max(r.drawing.board_size.x, r.drawing.board_size.y);
  return drawn_mm > 0 ? round_step(drawn_mm / worst, 1) : 1;
}

std::string error_colour(double part) {
  if (!std::isfinite(part)) return "hsl(0 70% 45%)";
  part = std::abs(part);
  // Teal (170) through green and amber to orange (30) at the limit; beyond it, red at once.
  const double hue = part > 1 ? 0 : 170 - 140 * part * part;
  return fmt::format("hsl({:.0f} 62% 42%)", hue);
}

std::string height_view(const JobResult& r) {
  if (r.actual.empty() && r.planned.empty()) return {};
  const auto planned = aligned(r);
  Axes a;
  a.y0 = 0, a.y1 = 10, a.x1 = 1e-3;
  for (const auto* path : {&planned, &r.actual})
    for (const auto& p : *path) {
      const double z = tip_at(r, p).z;
      if (!std::isfinite(z)) continue;
      a.y0 = std::min(a.y0, z), a.y1 = std::max(a.y1, z), a.x1 = std::max(a.x1, p.t_s);
    }
  Svg svg(kWidth, 226, "height of the tool over time");
  const double step_y = round_step(a.y1 - a.y0, 5), step_x = round_step(a.x1, 12);
  for (double y = std::ceil(a.y0 / step_y) * step_y; y <= a.y1; y += step_y) {
    svg.line(a.px(a.x0, y), a.px(a.x1, y), y == 0 ? "grid zero" : "grid");
    svg.words(a.px(a.x0, y) + Vec2{-6, 4}, html::number(y, 0), "tick", "end");
  }
  for (double x = 0; x <= a.x1; x += step_x)
    svg.words({a.px(x, 0).x, a.bottom + 18}, html::number(x, step_x < 1 ? 1 : 0) + " s", "tick", "middle");

  // The valve first, as bands behind the line.
  std::vector<Vec2> bands;  // from, to
  for (std::size_t i = 0; i < r.actual.size(); ++i) {
    if (!r.actual[i].valve) continue;
    std::size_t j = i;
    while (j + 1 < r.actual.size() && r.actual[j].valve) ++j;
    const double from = a.px(r.actual[i].t_s, 0).x, to = a.px(r.actual[j].t_s, 0).x;
    if (bands.empty() || from > bands.back().y + 0.5)
      bands.push_back({from, to});
    else
      bands.back().y = to;  // as near as this they cannot be seen apart
    i = j;
  }
  for (const Vec2 band : bands)
    svg.rect({band.x, a.top}, {std::max(0.6, band.y - band.x), a.bottom - a.top}, "valve-band");
  const auto draw = [&](const std::vector<PathPoint>& path, const char* css) {
    std::vector<Vec2> points;
    std::uint32_t block = 0;
    for (const auto& p : path) {
      const double z = tip_at(r, p).z;
      if (!std::isfinite(z) || !std::isfinite(p.t_s)) continue;
      const Vec2 at = a.px(p.t_s, z);
      // Another block is another tool, whose tip is elsewhere: the line begins anew.
      if (p.block != block) svg.path(envelope(points), css), points.clear();
      block = p.block;
      points.push_back(at);
    }
    svg.path(envelope(points), css);
  };
  draw(planned, "planned");
  draw(r.actual, "actual");
  for (const auto& c : r.collisions) svg.line(a.px(c.t_s, a.y0), a.px(c.t_s, a.y1), "hit", {});
  return svg.done();
}

std::string histogram_view(const std::vector<HistogramBucket>& buckets) {
  if (buckets.empty()) return {};
  std::map<int, std::uint64_t> bars;  // by quarter octave
  for (const auto& b : buckets)
    bars[static_cast<int>(std::floor(4 * std::log2(std::max<double>(1, static_cast<double>(b.upper_ns)))))] += b.count;
  std::uint64_t most = 1;
  for (const auto& [octave, count] : bars) most = std::max(most, count);

  Axes a;
  a.right = 478, a.top = 8, a.bottom = 150, a.left = 40;
  a.x0 = bars.begin()->first - 1, a.x1 = bars.rbegin()->first + 2;
  a.y0 = 0, a.y1 = std::log10(static_cast<double>(most)) + 0.15;
  if (a.x1 - a.x0 < 12) a.x0 -= 6, a.x1 += 6;
  Svg svg(486, 176, "histogram");
  for (int power = 0; power <= static_cast<int>(a.y1); ++power) {
    svg.line(a.px(a.x0, power), a.px(a.x1, power), "grid");
    svg.words(a.px(a.x0, power) + Vec2{-6, 4},
              power < 4 ? html::number(std::pow(10, power), 0) : fmt::format("1e{}", power), "tick", "end");
  }
  for (const double ns : {1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9}) {
    const double x = 4 * std::log2(ns);
    if (x < a.x0 || x > a.x1) continue;
    svg.line(a.px(x, a.y0), a.px(x, a.y1), "grid");
    const auto label = ns < 1e3   ? html::number(ns, 0) + " ns"
                       : ns < 1e6 ? html::number(ns / 1e3, 0) + " µs"
                                  : html::number(ns / 1e6, 0) + " ms";
    svg.words({a.px(x, 0).x, a.bottom + 18}, label, "tick", "middle");
  }
  for (const auto& [octave, count] : bars) {
    const double height = std::log10(static_cast<double>(count)) + 0.12;  // a single one is still seen
    const Vec2 top = a.px(octave + 0.08, std::min(height, a.y1)), end = a.px(octave + 0.92, 0);
    svg.rect(top, {end.x - top.x, a.bottom - top.y}, "bar");
  }
  return svg.done();
}

}  // namespace gantry::record
