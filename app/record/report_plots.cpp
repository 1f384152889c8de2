#include "app/record/report_plots.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "app/record/plot_axes.hpp"
#include "app/record/polyline.hpp"
#include "app/record/svg.hpp"

namespace gantry::record {
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

std::string following_view(const AxisResult& axis) {
  if (axis.over_time.empty() || !axis.measured) return {};
  constexpr double unit = 1000;  // to mrad, or to um
  Axes a;
  a.right = 478, a.top = 8, a.bottom = 90, a.left = 46;
  a.x0 = axis.over_time.front().t_s, a.x1 = std::max(axis.over_time.back().t_s, a.x0 + 1e-3);
  double most = 0;
  for (const EnvelopePoint& p : axis.over_time) most = std::max({most, p.value * unit, p.limit * unit});
  a.y1 = most * 1.08;
  Svg svg(486, 112, "following error of " + axis.name + " over time");
  const double step_y = round_step(a.y1, 3), step_x = round_step(a.x1 - a.x0, 6);
  for (double y = 0; y <= a.y1; y += step_y) {
    svg.line(a.px(a.x0, y), a.px(a.x1, y), "grid");
    svg.words(a.px(a.x0, y) + Vec2{-6, 4}, html::number(y, step_y < 1 ? 1 : 0), "tick", "end");
  }
  for (double x = std::ceil(a.x0 / step_x) * step_x; x <= a.x1; x += step_x)
    svg.words_below({a.px(x, 0).x, a.bottom + 16}, html::number(x, step_x < 1 ? 1 : 0) + " s", "tick");
  std::vector<Vec2> value, limit;
  for (const EnvelopePoint& p : axis.over_time) {
    value.push_back(a.px(p.t_s, p.value * unit));
    limit.push_back(a.px(p.t_s, p.limit * unit));
  }
  svg.path(envelope(limit), "limit");
  svg.path(envelope(value), "actual");
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
    svg.words_below({a.px(x, 0).x, a.bottom + 18}, label, "tick");
  }
  for (const auto& [octave, count] : bars) {
    const double height = std::log10(static_cast<double>(count)) + 0.12;  // a single one is still seen
    const Vec2 top = a.px(octave + 0.08, std::min(height, a.y1)), end = a.px(octave + 0.92, 0);
    svg.rect(top, {end.x - top.x, a.bottom - top.y}, "bar");
  }
  return svg.done();
}

}  // namespace gantry::record
