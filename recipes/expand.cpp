#include "recipes/expand.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <set>
#include <utility>

#include "core/near_word.hpp"
#include "core/sha256.hpp"
#include "recipes/curves.hpp"
#include "recipes/fill.hpp"
#include "recipes/on_board.hpp"
#include "recipes/points_file.hpp"

namespace gantry::recipes {

using config::At;
using config::Mistakes;
using written::FeatureKind;
using written::FeatureRow;

namespace {

constexpr std::size_t kMostFeatures = 100000;

bool has(const FeatureRow& row, std::string_view key) {
  return std::find(row.keys.begin(), row.keys.end(), key) != row.keys.end();
}

Vec3 raised(Vec2 p, double z) { return {p.x, p.y, z}; }

Bead bead_of(const FeatureRow& row, const char* kind, bool closed = false) {
  return {row.name.value, {}, closed, row.corner_tolerance, row.material.value, row.location, kind, 0};
}

/// Corners of a rectangle as it is written.
std::vector<Vec2> corners(const FeatureRow& row) {
  const Vec2 s = row.size.value;
  std::vector<Vec2> out;
  for (const Vec2 p : {Vec2{0, 0}, Vec2{s.x, 0}, s, Vec2{0, s.y}})
    out.push_back(flat(row.at.value) + rotated(p, row.rotation));
  return out;
}

}  // namespace

void Expander::add(const FeatureRow& row) {
  const std::size_t first = to_.features.size();
  off_board_ = row.off_board, name_ = row.name.value;
  if (row.unread) return;
  expand(row);
  for (std::size_t i = first; i < to_.features.size(); ++i)
    std::visit([&](auto& feature) { feature.off_board = row.off_board; }, to_.features[i]);
  if (row.on.given()) put_on_part(row, first);
}

void Expander::put_on_part(const FeatureRow& row, std::size_t first) {
  const auto found = std::find_if(to_.parts.begin(), to_.parts.end(),
                                  [&](const Part& p) { return !p.fixture && p.name == row.on.value; });
  if (found == to_.parts.end()) {
    std::vector<std::string_view> known;
    for (const Part& p : to_.parts)
      if (!p.fixture) known.push_back(p.name);
    if (known.empty() && !all_read_) return;
    mistakes_.add(Fault::UnknownReference,
                  fmt::format("there is no part '{}'; {}", row.on.value, did_you_mean(row.on.value, known)),
                  row.on.location);
    return;
  }
  const Part& part = *found;
  bool told = part.unread;
  const auto judge_point = [&](Vec2 p) {
    constexpr double kSlack = 1e-9;
    const Vec2 from = rotated(p - part.at, -part.rotation);
    if (told || (std::abs(from.x) <= part.size.x / 2 + kSlack && std::abs(from.y) <= part.size.y / 2 + kSlack)) return;
    told = true;
    mistakes_.add(Fault::OutOfRange,
                  fmt::format("the point at ({:.6g}, {:.6g}) mm is not on '{}', whose top is {:.6g} x {:.6g} mm about "
                              "({:.6g}, {:.6g}) mm",
                              p.x, p.y, part.name, part.size.x, part.size.y, part.at.x, part.at.y),
                  row.on.location);
  };
  for (std::size_t i = first; i < to_.features.size(); ++i) {
    if (auto* one = std::get_if<Dot>(&to_.features[i])) {
      one->on = part.name, one->height_mm += part.size.z;
      judge_point(one->at);
    } else if (auto* bead = std::get_if<Bead>(&to_.features[i])) {
      bead->on = part.name;
      for (Vec3& p : bead->points) p.z += part.size.z, judge_point(flat(p));
    }
  }
}

void Expander::expand(const FeatureRow& row) {
  switch (row.kind) {
    case FeatureKind::Dot: return dot(row);
    case FeatureKind::Array: return array(row);
    case FeatureKind::Line: return line(row);
    case FeatureKind::Polyline: return polyline(row);
    case FeatureKind::Rectangle: return rectangle(row);
    case FeatureKind::Arc: return arc(row);
    case FeatureKind::Circle: return circle(row);
    case FeatureKind::Spiral: return spiral(row);
    case FeatureKind::Fill: return fill(row);
  }
}

bool Expander::require(Vec2 p, Location location, std::string_view what, Mistakes& mistakes) const {
  return off_board_ || require_on_board(to_.board, p, location, fmt::format("{} of '{}'", what, name_), mistakes,
                                        "; 'off_board: true' lets a feature leave it");
}

std::size_t Expander::points_left() const { return kMostPoints - std::min(points_, kMostPoints); }

void Expander::add_bead(Bead bead) {
  points_ += bead.points.size();
  if (points_ > kMostPoints) {
    if (!full_)
      mistakes_.add(Fault::TooManySteps,
                    fmt::format("a recipe holds at most {} points of beads; split it", kMostPoints), bead.location);
    full_ = true;
    return;
  }
  to_.features.emplace_back(std::move(bead));
}

bool Expander::stays_on_board(const std::vector<Vec3>& points, Location location, std::string_view what) {
  const auto off =
      std::find_if(points.begin(), points.end(), [&](Vec3 p) { return !off_board_ && !on_board(to_.board, flat(p)); });
  return off == points.end() || require(flat(*off), location, what, mistakes_);
}

void Expander::judge(const std::vector<At<Vec3>>& points, Judge by, Mistakes& mistakes) const {
  if (!by.on_board && !by.apart && !by.open_end) return;
  for (std::size_t i = 0; i < points.size() && !mistakes.full(); ++i) {
    if (by.on_board) require(flat(points[i].value), points[i].location, "point", mistakes);
    if (by.apart && i > 0 && points[i].value == points[i - 1].value)
      mistakes.add(Fault::Inconsistent, "the same point twice in a row", points[i].location);
  }
  if (by.open_end && points.size() > 1 && points.front().value == points.back().value)
    mistakes.add(Fault::Inconsistent, "a closed bead goes back by itself; leave out its last point",
                 points.back().location);
}

int Expander::group(const FeatureRow& row, std::vector<const char*> first, std::vector<const char*> second) {
  const auto words = [](const std::vector<const char*>& keys) {
    return fmt::format("'{}'", fmt::join(keys, "' and '"));
  };
  const auto any = [&](const std::vector<const char*>& keys) {
    return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return has(row, key); });
  };
  const bool one = any(first), other = any(second);
  if (one == other) {
    mistakes_.add(one ? Fault::Inconsistent : Fault::MissingKey,
                  fmt::format("{} or {} belong here{}", words(first), words(second), one ? ", not both" : ""),
                  row.location);
    return -1;
  }
  for (const char* key : one ? first : second)
    if (!has(row, key)) {
      mistakes_.add(Fault::MissingKey,
                    fmt::format("'{}' is missing here; {} belong together", key, words(one ? first : second)),
                    row.location);
      return -1;
    }
  return one ? 0 : 1;
}

// ---- dots ----

void Expander::dot(const FeatureRow& row) {
  if (row.at.given()) require(flat(row.at.value), row.at.location, "point", mistakes_);
  to_.features.emplace_back(Dot{row.name.value, flat(row.at.value), row.material.value, row.location, row.at.value.z});
}

void Expander::array(const FeatureRow& row) {
  if ((row.columns > 1 && row.pitch.value.x == 0) || (row.rows > 1 && row.pitch.value.y == 0))
    mistakes_.add(Fault::Inconsistent, "with a pitch of 0 several dots lie on one spot", row.pitch.location);
  const auto count = static_cast<std::size_t>(row.rows) * static_cast<std::size_t>(row.columns);
  if (to_.features.size() + count > kMostFeatures) {
    mistakes_.add(Fault::TooManySteps,
                  fmt::format("{} x {} dots; a recipe holds at most {} features", row.rows, row.columns, kMostFeatures),
                  row.location);
    return;
  }
  const std::set<std::pair<int, int>> skip(row.skip.begin(), row.skip.end());
  std::vector<Vec3> points;
  for (int r = 0; r < row.rows; ++r)
    // To and fro, so that the travel from row to row is short.
    for (int k = 0; k < row.columns; ++k) {
      const int c = r % 2 == 0 ? k : row.columns - 1 - k;
      if (skip.count({r, c})) continue;
      const Vec2 p = flat(row.at.value) + rotated({c * row.pitch.value.x, r * row.pitch.value.y}, row.rotation);
      points.push_back(raised(p, row.at.value.z));
      to_.features.emplace_back(
          Dot{fmt::format("{}[{}][{}]", row.name.value, r, c), p, row.material.value, row.location, row.at.value.z});
    }
  if (points.empty() && count > 0)
    mistakes_.add(Fault::Inconsistent, "every dot of the array is skipped; leave the array out", row.location);
  stays_on_board(points, row.at.location, "array's dot");
}

// ---- straight beads ----

void Expander::line(const FeatureRow& row) {
  for (const auto* end : {&row.at, &row.to})
    if (end->given()) require(flat(end->value), end->location, "point", mistakes_);
  if (row.at.given() && row.to.given() && row.at.value == row.to.value)
    mistakes_.add(Fault::Inconsistent, "the bead ends where it starts", row.to.location);
  Bead bead = bead_of(row, "line");
  bead.points = {row.at.value, row.to.value};
  add_bead(std::move(bead));
}

std::size_t Expander::file_named(const std::string& name) {
  const auto [found, is_new] = file_of_.emplace(name, files_.size());
  if (is_new) {
    files_.push_back({.mistakes = Mistakes(shown_beside(to_.file, name))});
    read(name, files_.back());
  }
  return found->second;
}

void Expander::read(const std::string& name, PointsFile& to) {
  if (!beside_) {
    to.unreadable = {Fault::FileUnreadable, "a recipe that is no file has no folder in which points could lie", {}};
    return;
  }
  const auto text = beside_(name);
  if (!text) {
    to.unreadable = text.error();
    return;
  }
  bytes_of_files_ += text->size();
  if (bytes_of_files_ > kMostBytesOfPoints) {
    to.unreadable = {Fault::FileTooLarge,
                     fmt::format("with '{}' the recipe's files of points hold more than {} bytes; split the recipe",
                                 config::shortened(name, 40), kMostBytesOfPoints),
                     {}};
    full_ = true;
    return;
  }
  const std::string& shown = to.mistakes.file();
  if (std::none_of(to_.sources.begin(), to_.sources.end(), [&](const Source& s) { return s.file == shown; }))
    to_.sources.push_back({shown, text->size(), sha256_hex(*text)});
  to.points = read_points(*text, to.mistakes);
  if (to.mistakes.none() && to.points.size() < 2)
    to.mistakes.add(
        Fault::OutOfRange,
        fmt::format("{} here; at least 2 are wanted", to.points.empty() ? "no point stands" : "1 point stands"),
        {1, 1});
}

std::vector<Vec3> Expander::from_file(const FeatureRow& row) {
  if (!row.points_file.given()) return {};
  PointsFile& file = files_[file_named(row.points_file.value)];
  if (file.unreadable) {
    mistakes_.add(file.unreadable->fault, file.unreadable->message, row.points_file.location);
    return {};
  }
  // Each of these is told once, whichever feature asks for it first.
  Judge& left = file.left;
  const Judge by{left.on_board && !off_board_, left.apart, left.open_end && row.closed};
  judge(file.points, by, file.mistakes);
  left = {left.on_board && !by.on_board, left.apart && !by.apart, left.open_end && !by.open_end};
  const std::size_t told = file.mistakes.errors().size();
  told_in_files_ += told - std::exchange(file.told, told);
  std::vector<Vec3> out;
  for (const auto& p : file.points) out.push_back(p.value);
  return out;
}

std::vector<Error> Expander::mistakes_in_files() const {
  std::vector<Error> all;
  for (const PointsFile& file : files_)
    for (Error& e : file.mistakes.errors()) all.push_back(std::move(e));
  return all;
}

void Expander::polyline(const FeatureRow& row) {
  Bead bead = bead_of(row, "polyline", row.closed);
  const int from = group(row, {"points"}, {"points_file"});
  if (from == 0) {
    judge(row.points, {true, true, row.closed}, mistakes_);
    for (const auto& p : row.points) bead.points.push_back(p.value);
  } else if (from == 1) {
    bead.points = from_file(row);
  }
  if (row.closed && !bead.points.empty()) bead.points.push_back(bead.points.front());
  add_bead(std::move(bead));
}

void Expander::rectangle(const FeatureRow& row) {
  Bead bead = bead_of(row, "rectangle", true);
  for (const Vec2 p : corners(row)) bead.points.push_back(raised(p, row.at.value.z));
  bead.points.push_back(bead.points.front());
  stays_on_board(bead.points, row.at.location, "corner");
  add_bead(std::move(bead));
}

// ---- curves ----

void Expander::add_curve(const FeatureRow& row, Result<Curve> curve, const char* kind, bool closed) {
  const Location location = row.centre.given() ? row.centre.location : row.at.location;
  if (!curve) {
    mistakes_.add(curve.error().fault, curve.error().message, row.location);
    return;
  }
  Bead bead = bead_of(row, kind, closed);
  bead.corner_tolerance = row.curve_tolerance;
  bead.points = std::move(curve->points);
  bead.curve_mm = curve->length_mm;
  stays_on_board(bead.points, location, "curve's point");
  add_bead(std::move(bead));
}

void Expander::arc(const FeatureRow& row) {
  const int by = group(row, {"through", "to"}, {"centre", "angle"});
  const bool known = row.at.given() && (by == 0   ? row.through.given() && row.to.given()
                                        : by == 1 ? row.centre.given() && row.angle.given()
                                                  : false);
  if (!known) return;
  if (by == 1 && has(row, "centre") && row.centre.value.z != 0 && row.centre.value.z != row.at.value.z) {
    mistakes_.add(Fault::Inconsistent, "an arc about a centre is level with 'from'; leave out the centre's height",
                  row.centre.location);
    return;
  }
  const Result<Arc> arc = by == 0 ? arc_through(row.at.value, row.through.value, row.to.value)
                                  : arc_about(flat(row.centre.value), row.at.value, row.angle.value);
  if (!arc) {
    mistakes_.add(arc.error().fault, arc.error().message, by == 0 ? row.through.location : row.centre.location);
    return;
  }
  double tolerance_mm = row.curve_tolerance;
  if (const bool level = arc->ahead.z == 0 && arc->aside.z == 0; !level)
    if (const Material* m = find_material(to_, row.material.value); m != nullptr && m->gap > 0)
      tolerance_mm = upright_tolerance_mm(tolerance_mm, *m);
  add_curve(row, sample(*arc, tolerance_mm * kSagOfTolerance, points_left()), "arc", arc->from == arc->to);
}

void Expander::circle(const FeatureRow& row) {
  if (!row.centre.given() || !row.from_radius.given()) return;
  const Vec2 out = rotated({row.from_radius.value, 0}, row.start_angle);
  const Vec3 from = row.centre.value + raised(out, 0);
  const auto arc = arc_about(flat(row.centre.value), from, (row.clockwise ? -2 : 2) * std::numbers::pi);
  if (arc) add_curve(row, sample(*arc, row.curve_tolerance * kSagOfTolerance, points_left()), "circle", true);
}

void Expander::spiral(const FeatureRow& row) {
  if (!row.centre.given() || !row.from_radius.given() || !row.to_radius.given() || !row.spacing.given()) return;
  const double from = row.from_radius.value, to = row.to_radius.value;
  if (std::abs(to - from) < 1e-3) {
    mistakes_.add(Fault::Inconsistent, "the spiral ends at the radius where it starts; write a 'circle'",
                  row.to_radius.location);
    return;
  }
  const Spiral spiral{row.centre.value, from, to, row.spacing.value, row.start_angle, row.clockwise};
  add_curve(row, sample(spiral, row.curve_tolerance * kSagOfTolerance, points_left()), "spiral", false);
}

// ---- areas ----

void Expander::fill(const FeatureRow& row) {
  const int by = group(row, {"at", "size"}, {"points"});
  std::vector<Vec2> outline;
  double height = row.at.value.z;
  Location location = row.at.location;
  if (by == 0 && row.at.given() && row.size.given()) {
    outline = corners(row);
    std::vector<Vec3> all;
    for (const Vec2 p : outline) all.push_back(raised(p, height));
    stays_on_board(all, location, "corner");
  } else if (by == 1 && !row.points.empty()) {
    for (const auto& p : row.points) require(flat(p.value), p.location, "corner", mistakes_);
    height = row.points.front().value.z, location = row.points.front().location;
    for (const auto& p : row.points) {
      outline.push_back(flat(p.value));
      if (p.value.z == height) continue;
      mistakes_.add(Fault::Inconsistent, "the corners of a fill lie at one height; give this one that of the first",
                    p.location);
      return;
    }
    if (row.rotation != 0)
      mistakes_.add(Fault::Inconsistent, "'rotation' turns a rectangle; a polygon's corners are written as they lie",
                    row.location);
  }
  if (outline.empty() || !row.spacing.given()) return;
  const auto filled =
      fill_area(outline, {row.spacing.value, row.line_angle, row.serpentine}, std::max<std::size_t>(points_left(), 2));
  if (!filled) {
    mistakes_.add(filled.error().fault, filled.error().message, location);
    return;
  }
  to_.fills.push_back({row.name.value, filled->area_mm2, row.spacing.value, to_.features.size(), filled->runs.size(),
                       filled->bare.share, filled->bare.farthest_mm, filled->bare.at, row.location});
  if (to_.features.size() + filled->runs.size() > kMostFeatures) {
    mistakes_.add(Fault::TooManySteps,
                  fmt::format("{} lines; a recipe holds at most {} features", filled->runs.size(), kMostFeatures),
                  row.location);
    return;
  }
  for (std::size_t i = 0; i < filled->runs.size(); ++i) {
    Bead bead = bead_of(row, "fill");
    if (filled->runs.size() > 1) bead.id = fmt::format("{}[{}]", row.name.value, i);
    for (const Vec2 p : filled->runs[i]) bead.points.push_back(raised(p, height));
    add_bead(std::move(bead));
  }
}

}  // namespace gantry::recipes
