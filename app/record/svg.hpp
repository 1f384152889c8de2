// Writes SVG elements; colours and strokes are classes of the page's style sheet.
//   Svg svg(900, 600);   svg.line({0, 0}, {10, 10}, "grid");   svg.done();
#pragma once
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <vector>

#include "app/record/html.hpp"
#include "core/vec.hpp"

namespace gantry::record {

class Svg {
 public:
  Svg(double width, double height, std::string_view label) : width_(width) {
    constexpr double kLarge = 700;  // whose words have to be larger where the page is narrow
    out_ = fmt::format(R"(<svg viewBox="0 0 {:.0f} {:.0f}" class="{}" role="img" aria-label="{}">)", width, height,
                       width > kLarge ? "large" : "small", html::text(label));
  }
  /// `style` is raw CSS of ours ("stroke-width:3"), never text from outside.
  void line(Vec2 a, Vec2 b, std::string_view css, std::string_view style = {}) {
    out_ += fmt::format(R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" class="{}"{}/>)", a.x, a.y, b.x, b.y,
                        css, styled(style));
  }
  void rect(Vec2 at, Vec2 size, std::string_view css, std::string_view style = {}) {
    out_ += fmt::format(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" class="{}"{}/>)", at.x, at.y,
                        size.x, size.y, css, styled(style));
  }
  /// `title` is what hovering shows.
  void circle(Vec2 at, double radius, std::string_view css, std::string_view style = {}, std::string_view title = {}) {
    out_ += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}" class="{}"{}>{}</circle>)", at.x, at.y, radius,
                        css, styled(style), titled(title));
  }
  void path(const std::vector<Vec2>& points, std::string_view css, bool closed = false, std::string_view style = {},
            std::string_view title = {}) {
    if (points.empty()) return;
    out_ += "<path d=\"M";
    for (const auto& p : points) out_ += fmt::format("{:.1f} {:.1f} ", p.x, p.y);
    if (closed) out_ += 'Z';
    out_ += fmt::format(R"(" class="{}"{}>{}</path>)", css, styled(style), titled(title));
  }
  /// Many of one size and colour, which are the stroke's.
  void dots(const std::vector<Vec2>& at, std::string_view css, std::string_view style) {
    out_ += "<path d=\"";
    for (const auto& p : at) out_ += fmt::format("M{:.1f} {:.1f}h0", p.x, p.y);
    out_ += fmt::format(R"(" class="{}"{}></path>)", css, styled(style));
  }
  void words(Vec2 at, std::string_view text, std::string_view css, std::string_view anchor = "start") {
    out_ += fmt::format(R"(<text x="{:.1f}" y="{:.1f}" class="{}" text-anchor="{}">{}</text>)", at.x, at.y, css, anchor,
                        html::text(text));
  }
  /// Of a value below an axis: in the middle under it, or where that would leave the picture, up to its edge.
  void words_below(Vec2 at, std::string_view text, std::string_view css) {
    constexpr double kHalfLetter = 3.2;  // px, at the size of a tick
    const bool leaves = at.x + kHalfLetter * static_cast<double>(text.size()) > width_;
    words({leaves ? width_ - 1 : at.x, at.y}, text, css, leaves ? "end" : "middle");
  }
  void begin_group(std::string_view css) { out_ += fmt::format(R"(<g class="{}">)", css); }
  void end_group() { out_ += "</g>"; }
  void begin_clip(Vec2 at, Vec2 size, std::string_view id) {
    out_ += fmt::format(R"(<clipPath id="{}"><rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}"/></clipPath>)"
                        "<g clip-path='url(#{})'>",
                        id, at.x, at.y, size.x, size.y, id);
  }
  void end_clip() { out_ += "</g>"; }
  [[nodiscard]] std::string done() const { return out_ + "</svg>\n"; }

 private:
  static std::string styled(std::string_view style) {
    return style.empty() ? std::string() : fmt::format(R"( style="{}")", style);
  }
  static std::string titled(std::string_view title) {
    return title.empty() ? std::string() : fmt::format("<title>{}</title>", html::text(title));
  }
  double width_;
  std::string out_;
};

/// Classes of a number at an axis' grid line: on a narrow page one in three is shown. `side`: "below" or "beside" it.
inline std::string tick_css(double index, std::string_view side) {
  return fmt::format("tick {}{}", side, std::llround(index) % 3 == 0 ? "" : " wide");
}

/// A round step (1, 2 or 5 times a power of ten) that cuts `range` into about `parts`.
inline double round_step(double range, double parts) {
  const double raw = range / parts;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double lead = raw / power;
  return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

}  // namespace gantry::record
