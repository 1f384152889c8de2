#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "core/near_word.hpp"
#include "recipes/recipe_file.hpp"

namespace gantry::recipes {
namespace {

using config::Mistakes;
using written::FeatureKind;
using written::FeatureRow;

constexpr std::size_t kMostFeatures = 100000;

/// What can be judged without a machine: names, the board's outline, points that coincide.
class Checker {
 public:
  Checker(const Recipe& recipe, Mistakes& mistakes) : recipe_(recipe), mistakes_(mistakes) {}

  void board_items() {
    for (const MarkDef& m : recipe_.marks) {
      on_board(m.at, m.place, "mark");
      for (const Part& p : recipe_.parts)
        if (covers(p, m.at, m.diameter / 2))
          mistakes_.add(Fault::Inconsistent, fmt::format("'{}' covers the mark: the camera looks from above", p.name),
                        m.place);
    }
    for (const TouchPoint& t : recipe_.touches) on_board(t.at, t.place, "touch point");
    touches_give_a_plane();
    std::set<std::string> names;
    for (const Part& p : recipe_.parts) {
      if (!names.insert(p.name).second)
        mistakes_.add(Fault::DuplicateKey, fmt::format("a part and a fixture are both called '{}'", p.name), p.place);
      if (!p.fixture) on_board(p.at, p.place, "part");
    }
  }

  void feature(const FeatureRow& row) {
    if (row.name.given() && !names_.insert(row.name.value).second)
      mistakes_.add(Fault::DuplicateKey, fmt::format("another feature is called '{}' already", row.name.value),
                    row.name.place);
    if (row.material.given() && !find_material(recipe_, row.material.value)) {
      std::vector<std::string_view> known;
      for (const Material& m : recipe_.materials) known.push_back(m.name);
      mistakes_.add(
          Fault::UnknownReference,
          fmt::format("there is no material '{}'; {}", row.material.value, did_you_mean(row.material.value, known)),
          row.material.place);
    }
    if (row.at.given() && (row.kind == FeatureKind::Dot || row.kind == FeatureKind::Line))
      on_board(row.at.value, row.at.place, "point");
    if (row.to.given()) on_board(row.to.value, row.to.place, "point");
    if (row.kind == FeatureKind::Line && row.at.given() && row.to.given() && row.at.value == row.to.value)
      mistakes_.add(Fault::Inconsistent, "the bead ends where it starts", row.to.place);
    for (std::size_t i = 0; i < row.points.size(); ++i) {
      on_board(row.points[i].value, row.points[i].place, "point");
      if (i > 0 && row.points[i].value == row.points[i - 1].value)
        mistakes_.add(Fault::Inconsistent, "the same point twice in a row", row.points[i].place);
    }
    if ((row.columns > 1 && row.pitch.value.x == 0) || (row.rows > 1 && row.pitch.value.y == 0))
      mistakes_.add(Fault::Inconsistent, "with a pitch of 0 several dots lie on one spot", row.pitch.place);
    if (row.closed && row.points.size() > 1 && row.points.front().value == row.points.back().value)
      mistakes_.add(Fault::Inconsistent, "a closed bead goes back by itself; leave out its last point",
                    row.points.back().place);
  }

  /// Of an array or a rectangle: the first of its points that leaves the board.
  void expanded(const std::vector<Vec2>& points, Place place, std::string_view what) {
    for (const Vec2 p : points)
      if (!inside(p)) {
        outside(p, place, what);
        return;
      }
  }

 private:
  /// Three touches and more are meant to measure the tilt in both directions; on one line they cannot.
  void touches_give_a_plane() {
    constexpr double kWidth = 0.1;  // of the line's length; nearer to it, the touches' errors turn the plane about it
    if (recipe_.touches.size() < 3) return;
    const Vec2 from = recipe_.touches.front().at;
    const auto farthest = std::max_element(recipe_.touches.begin(), recipe_.touches.end(),
                                           [&](auto& a, auto& b) { return norm(a.at - from) < norm(b.at - from); });
    const Vec2 along = farthest->at - from;
    const double length = norm(along);
    double width = 0;
    for (const TouchPoint& t : recipe_.touches)
      if (length > 0) width = std::max(width, std::abs(dot(Vec2{-along.y, along.x}, t.at - from)) / length);
    if (width < kWidth * length || length == 0)
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("the {} touches lie on one line, so the tilt across it stays unmeasured; put one at "
                                "least {:.6g} mm beside it",
                                recipe_.touches.size(), std::max(1.0, kWidth * length)),
                    recipe_.touches.back().place);
  }
  /// A part, or a fixture with the board in its nominal place, over any point of a disc.
  [[nodiscard]] static bool covers(const Part& part, Vec2 at, double radius) {
    const Vec2 p = rotated(at - part.at, -part.rotation);
    const Vec2 beyond{std::max(0.0, std::abs(p.x) - part.size.x / 2), std::max(0.0, std::abs(p.y) - part.size.y / 2)};
    return norm(beyond) < radius;
  }
  [[nodiscard]] bool inside(Vec2 p) const {
    const Vec2 size = recipe_.board.size;
    constexpr double kSlack = 1e-9;
    return size.x <= 0 || (p.x >= -kSlack && p.y >= -kSlack && p.x <= size.x + kSlack && p.y <= size.y + kSlack);
  }
  void outside(Vec2 p, Place place, std::string_view what) {
    mistakes_.add(Fault::OutOfRange,
                  fmt::format("the {} at ({:.6g}, {:.6g}) mm is off the board, which is {:.6g} x {:.6g} mm", what, p.x,
                              p.y, recipe_.board.size.x, recipe_.board.size.y),
                  place);
  }
  void on_board(Vec2 p, Place place, std::string_view what) {
    if (!inside(p)) outside(p, place, what);
  }

  const Recipe& recipe_;
  Mistakes& mistakes_;
  std::set<std::string> names_;
};

void expand_array(const FeatureRow& row, Recipe& to, Checker& check, Mistakes& mistakes) {
  const auto count = static_cast<std::size_t>(row.rows) * static_cast<std::size_t>(row.columns);
  if (to.features.size() + count > kMostFeatures) {
    mistakes.add(Fault::TooManySteps,
                 fmt::format("{} x {} dots; a recipe holds at most {} features", row.rows, row.columns, kMostFeatures),
                 row.place);
    return;
  }
  const std::set<std::pair<int, int>> skip(row.skip.begin(), row.skip.end());
  std::vector<Vec2> points;
  for (int r = 0; r < row.rows; ++r)
    // To and fro, so that the way from row to row is short.
    for (int k = 0; k < row.columns; ++k) {
      const int c = r % 2 == 0 ? k : row.columns - 1 - k;
      if (skip.count({r, c})) continue;
      const Vec2 p = row.at.value + rotated({c * row.pitch.value.x, r * row.pitch.value.y}, row.rotation);
      points.push_back(p);
      to.features.emplace_back(Dot{fmt::format("{}[{}][{}]", row.name.value, r, c), p, row.material.value, row.place});
    }
  if (points.empty() && count > 0)
    mistakes.add(Fault::Inconsistent, "every dot of the array is skipped; leave the array out", row.place);
  check.expanded(points, row.at.place, "array's dot");
}

void expand(const FeatureRow& row, Recipe& to, Checker& check, Mistakes& mistakes) {
  Bead bead{row.name.value, {}, false, row.corner_tolerance, row.material.value, row.place};
  switch (row.kind) {
    case FeatureKind::Dot:
      to.features.emplace_back(Dot{row.name.value, row.at.value, row.material.value, row.place});
      return;
    case FeatureKind::Array: expand_array(row, to, check, mistakes); return;
    case FeatureKind::Line: bead.points = {row.at.value, row.to.value}; break;
    case FeatureKind::Polyline:
      for (const auto& p : row.points) bead.points.push_back(p.value);
      bead.closed = row.closed;
      if (row.closed && !bead.points.empty()) bead.points.push_back(bead.points.front());
      break;
    case FeatureKind::Rectangle: {
      const Vec2 s = row.size.value;
      for (const Vec2 p : {Vec2{0, 0}, Vec2{s.x, 0}, s, Vec2{0, s.y}, Vec2{0, 0}})
        bead.points.push_back(row.at.value + rotated(p, row.rotation));
      bead.closed = true;
      check.expanded(bead.points, row.at.place, "corner");
      break;
    }
  }
  to.features.emplace_back(std::move(bead));
}

}  // namespace

Checked<Recipe> parse(std::string_view yaml, std::string_view file) {
  Mistakes mistakes{std::string(file)};
  auto read = config::read_fields(yaml, written::recipe_fields(), mistakes);
  if (!read) return tl::unexpected(mistakes.errors());
  Recipe recipe = std::move(read->recipe);
  recipe.file = file;
  Checker check(recipe, mistakes);
  check.board_items();
  for (const FeatureRow& row : read->features) {
    check.feature(row);
    expand(row, recipe, check, mistakes);
    if (recipe.features.size() > kMostFeatures) break;
  }
  if (!mistakes.none()) return tl::unexpected(mistakes.errors());
  return recipe;
}

Checked<Recipe> load(const std::string& path) {
  const auto text = config::read_text_file(path);
  if (!text) return tl::unexpected(std::vector{text.error()});
  return parse(*text, path);
}

const Material* find_material(const Recipe& recipe, std::string_view name) {
  for (const Material& material : recipe.materials)
    if (material.name == name) return &material;
  return nullptr;
}

}  // namespace gantry::recipes
