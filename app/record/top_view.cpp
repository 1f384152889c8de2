// The board from above. Everything is drawn in the board's own frame, so that the picture looks like the recipe: paths
// of the machine are brought back through the work offset, and through the tip of the tool that worked in the block.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "app/record/deposit_figures.hpp"
#include "app/record/labels.hpp"
#include "app/record/polyline.hpp"
#include "app/record/report_geometry.hpp"
#include "app/record/report_plots.hpp"
#include "app/record/svg.hpp"

namespace gantry::record {
namespace {

constexpr double kWidth = 1000, kMaxHeight = 720, kFrame = 34;  // px
constexpr double kBead_mm = 0.7;                                // drawn width; the recipe knows no width
constexpr std::size_t kMostPoints = 20000;                      // of a line
constexpr std::size_t kMostTitles = 2000;                       // deposits that show their name when pointed at

struct View {
  double scale = 1;  // px per mm
  Vec2 low, high;    // mm that are shown
  [[nodiscard]] Vec2 px(Vec2 p) const { return {kFrame + (p.x - low.x) * scale, (high.y - p.y) * scale + 8}; }
  [[nodiscard]] Vec2 size() const { return (high - low) * scale; }
};

View view_of(const Drawing& d) {
  View v;
  v.low = {0, 0}, v.high = d.board_size;
  for (const auto& p : d.parts) {  // a clamp may stand beside the board
    const double r = 0.5 * std::hypot(p.size.x, p.size.y);
    v.low = {std::min(v.low.x, p.at.x - r), std::min(v.low.y, p.at.y - r)};
    v.high = {std::max(v.high.x, p.at.x + r), std::max(v.high.y, p.at.y + r)};
  }
  const double margin = 0.05 * std::max(v.high.x - v.low.x, v.high.y - v.low.y);
  v.low = v.low - Vec2{margin, margin}, v.high = v.high + Vec2{margin, margin};
  v.scale = std::min((kWidth - kFrame - 8) / (v.high.x - v.low.x), kMaxHeight / (v.high.y - v.low.y));
  return v;
}

Vec2 tip(const JobResult& r, const PathPoint& p) {
  const Vec3 at = tip_at(r, p);
  return {at.x, at.y};
}

/// Calls `draw(points, valve)` for each run of one block, cut where the valve switches when that is `by_valve`;
/// neighbours share their point.
template <class Draw>
void runs(const JobResult& r, const Path& path, const View& v, bool by_valve, Draw&& draw) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < path.size(); ++i) {
    points.push_back(v.px(tip(r, path[i])));
    const bool goes_on = i + 1 < path.size() && path[i + 1].block == path[i].block;
    if (goes_on && (!by_valve || path[i + 1].valve == path[i].valve)) continue;
    if (goes_on) points.push_back(v.px(tip(r, path[i + 1])));
    draw(thinned(points, kMostPoints), path[i].valve);
    points.clear();
  }
}

void draw_ground(Svg& svg, const View& v, const Drawing& d) {
  const double step = round_step(v.high.x - v.low.x, 12);
  for (double x = std::ceil(v.low.x / step) * step; x <= v.high.x; x += step) {
    svg.line(v.px({x, v.low.y}), v.px({x, v.high.y}), "grid");
    svg.words(v.px({x, v.low.y}) + Vec2{0, 16}, html::number(x, 0), tick_css(x / step, "below"), "middle");
  }
  for (double y = std::ceil(v.low.y / step) * step; y <= v.high.y; y += step) {
    svg.line(v.px({v.low.x, y}), v.px({v.high.x, y}), "grid");
    svg.words(v.px({v.low.x, y}) + Vec2{-6, 4}, html::number(y, 0), tick_css(y / step, "beside"), "end");
  }
  svg.rect(v.px({0, d.board_size.y}), d.board_size * v.scale, "board");
}

void draw_parts(Svg& svg, const View& v, const JobResult& r) {
  for (const auto& part : r.drawing.parts) {
    std::vector<Vec2> corners;
    for (const Vec2 c : {Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}}) {
      const Vec2 at = part.at + rotated({c.x * part.size.x / 2, c.y * part.size.y / 2}, part.rotation);
      corners.push_back(v.px(part.fixture ? to_board(r, at) : at));
    }
    const auto name = fmt::format("{}, {:.1f} mm high", part.name, part.size.z);
    svg.path(corners, part.fixture ? "fixture" : "part", true, {}, name);
  }
}

void draw_zones(Svg& svg, const View& v, const JobResult& r) {
  constexpr int kOfRound = 32;  // sides that a circle is drawn with
  for (const DrawnBody& zone : r.drawing.bodies) {
    if (zone.role != DrawnBody::Role::Zone) continue;
    const config::Body& body = zone.body;
    const bool box = body.shape.kind == config::Shape::Kind::Box;
    std::vector<Vec2> outline;
    for (int i = 0; i < (box ? 4 : kOfRound); ++i) {
      const double angle = 2 * std::numbers::pi * i / kOfRound;
      const Vec2 corner =
          box ? Vec2{i == 0 || i == 3 ? -1.0 : 1.0, i < 2 ? -1.0 : 1.0} : Vec2{std::cos(angle), std::sin(angle)};
      const Vec2 from =
          rotated({corner.x * body.shape.size.x / 2, corner.y * body.shape.size.y / 2}, body.rotation_rad);
      const Vec3 at = machine_to_board(r, body.centre + Vec3{from.x, from.y, 0});
      outline.push_back(v.px({at.x, at.y}));
    }
    svg.path(outline, "zone", true, {}, body.name);
  }
}

/// After everything else, so that lines do not cross the words.
void label_parts(Labels& labels, const View& v, const JobResult& r) {
  for (const auto& part : r.drawing.parts) {
    const Vec2 at = v.px(part.fixture ? to_board(r, part.at) : part.at);
    const double room = std::max(part.size.x, part.size.y) * v.scale;
    if (labels.width(part.name) < room * 1.3) labels.put(at + Vec2{0, 4}, part.name, "label", "middle");
  }
}

void draw_deposits(Svg& svg, const View& v, const JobResult& r) {
  const double width = std::max(3.0, kBead_mm * v.scale);
  const bool crowd = r.deposits.size() > kMostTitles;
  std::map<std::string, std::vector<Vec2>> dots;  // of a crowd, by colour
  for (const auto& d : r.deposits) {
    std::vector<Vec2> points;
    for (const Vec3& p : d.board_mm) points.push_back(v.px({p.x, p.y}));
    points = thinned(points, kMostPoints);  // a point a millisecond is far more than the picture can show
    if (points.empty()) continue;
    const auto title = fmt::format("{}: error {}, gap {} mm", d.id.empty() ? "on no feature" : d.id,
                                   html::micrometres(d.error_mm), html::number(d.gap_mm, 3));
    const bool judged = d.kind != "purge";  // a shot at the purge place may lie as it likes
    const auto colour = judged ? error_colour(d.error_mm / allowed(r, d).beside_mm) : "var(--muted)";
    if (crowd && (d.kind == "dot" || points.size() == 1)) {
      dots[colour].push_back(points.front());
    } else if (d.kind == "dot" || points.size() == 1) {
      svg.circle(points.front(), width * 0.8, "dot", "fill:" + colour, title);
    } else {
      svg.path(points, "bead", false, fmt::format("stroke:{};stroke-width:{:.1f}", colour, width), title);
    }
  }
  for (const auto& [colour, points] : dots)
    svg.dots(points, "bead", fmt::format("stroke:{};stroke-width:{:.1f}", colour, width * 1.6));
}

void draw_valve_path(Svg& svg, const View& v, const JobResult& r) {
  const double width = std::max(3.0, kBead_mm * v.scale);
  runs(r, r.actual, v, true, [&](const std::vector<Vec2>& points, bool valve) {
    if (!valve) return;
    double length = 0;
    for (std::size_t i = 1; i < points.size(); ++i) length += norm(points[i] - points[i - 1]);
    if (length < 1)
      svg.circle(points.front(), width * 0.8, "dot valve-dot");
    else
      svg.path(points, "bead valve-open", false, fmt::format("stroke-width:{:.1f}", width));
  });
}

void draw_marks(Svg& svg, const View& v, const JobResult& r) {
  const double scale = residual_magnification(r) * v.scale;
  for (const auto& m : r.marks) {
    const Vec2 at = v.px(m.nominal);
    svg.circle(at, 7, m.found ? "mark" : "mark mark-lost", {}, m.found ? m.name : m.name + ": not found, " + m.reason);
    if (!m.found) {
      svg.line(at + Vec2{-5, -5}, at + Vec2{5, 5}, "cross");
      svg.line(at + Vec2{-5, 5}, at + Vec2{5, -5}, "cross");
    } else if (r.has_offset) {
      const Vec2 e = to_board(r, m.measured) - m.nominal;
      svg.line(at, at + Vec2{e.x, -e.y} * scale, "residual");
    }
  }
}

void draw_touches(Svg& svg, const View& v, const JobResult& r) {
  for (const auto& t : r.touches) {
    const Vec2 at = v.px(t.at);
    svg.path({at + Vec2{-5, -5}, at + Vec2{5, -5}, at + Vec2{0, 4}}, "touch", true, {}, t.name);
    svg.words(at + Vec2{8, 0}, fmt::format("{:+.3f}", t.height_mm), "tick wide");
  }
}

void draw_collisions(Svg& svg, const View& v, const JobResult& r) {
  for (const auto& c : r.collisions) {
    const Vec3 board = machine_to_board(r, c.at);
    const Vec2 at = v.px({board.x, board.y});
    svg.circle(at, 13, "hit", {}, fmt::format("{} met {} at {:.3f} s", c.moving, c.standing, c.t_s));
    svg.line(at + Vec2{-6, -6}, at + Vec2{6, 6}, "cross");
    svg.line(at + Vec2{-6, 6}, at + Vec2{6, -6}, "cross");
  }
}

/// As the recipe draws them, where not all of it was dispensed.
void draw_asked(Svg& svg, const View& v, const JobResult& r) {
  if (r.features_done >= r.features_total) return;
  std::vector<Vec2> dots;
  for (const auto& feature : r.drawing.asked) {
    std::vector<Vec2> points;
    for (const Vec3& p : feature) {
      const Vec3 board = machine_to_board(r, p);
      points.push_back(v.px({board.x, board.y}));
    }
    if (points.size() == 1)
      dots.push_back(points.front());
    else
      svg.path(thinned(points, kMostPoints), "asked");
  }
  if (!dots.empty()) svg.dots(dots, "asked dot-asked", "stroke-width:4;stroke-linecap:round;stroke-dasharray:none");
}

/// The order in which features are dispensed; on a wide page with their names where there are few.
void label_features(Labels& labels, const View& v, const JobResult& r, bool with_names) {
  constexpr std::size_t kMostNames = 40, kMostNumbers = 400;
  if (r.feature_order.size() > kMostNumbers) return;
  for (std::size_t n = 0; n < r.feature_order.size(); ++n) {
    const std::size_t feature = r.feature_order[n];
    if (feature >= r.drawing.asked.size() || r.drawing.asked[feature].empty()) continue;
    const Vec3 start = machine_to_board(r, r.drawing.asked[feature].front());
    const Vec2 at = v.px({start.x, start.y}) + Vec2{6, -5};
    std::string words = std::to_string(n + 1);
    if (with_names && r.feature_order.size() <= kMostNames && feature < r.feature_names.size())
      words += " " + r.feature_names[feature];
    labels.put(at, words, "order");
  }
}

void label(Svg& svg, const View& v, const JobResult& r) {
  for (const auto page : {Labels::Page::Wide, Labels::Page::Phone}) {
    Labels labels(svg, page);
    label_parts(labels, v, r);
    label_features(labels, v, r, page == Labels::Page::Wide);
  }
}

void draw_end(Svg& svg, const View& v, const JobResult& r) {
  if (!ended_early(r) || r.actual.empty()) return;
  const Vec2 at = v.px(tip(r, r.actual.back()));
  svg.circle(at, 10, "stopped", {}, "the job ended here");
}

}  // namespace

std::string top_view(const JobResult& r) {
  const Drawing& d = r.drawing;
  if (!(d.board_size.x > 0 && d.board_size.y > 0)) return {};
  const View v = view_of(d);
  Svg svg(kFrame + v.size().x + 8, v.size().y + 34, "board from above with planned and actual path");
  draw_ground(svg, v, d);
  svg.begin_clip(v.px({v.low.x, v.high.y}), v.size(), "board-clip");
  draw_parts(svg, v, r);
  draw_zones(svg, v, r);
  draw_asked(svg, v, r);
  runs(r, r.planned, v, false, [&](const std::vector<Vec2>& points, bool) { svg.path(points, "planned"); });
  runs(r, r.actual, v, false, [&](const std::vector<Vec2>& points, bool) { svg.path(points, "actual"); });
  if (r.has_world)
    draw_deposits(svg, v, r);
  else
    draw_valve_path(svg, v, r);
  draw_touches(svg, v, r);
  draw_marks(svg, v, r);
  label(svg, v, r);
  draw_collisions(svg, v, r);
  draw_end(svg, v, r);
  svg.end_clip();
  return svg.done();
}

}  // namespace gantry::record
