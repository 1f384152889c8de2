#include "recipes/precedence.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

namespace gantry::recipes {
namespace {

constexpr std::size_t kMostPairs = std::size_t{1} << 21u, kMostLooks = std::size_t{1} << 28u;

/// A straight piece of a feature, seen from above; a dot is one without a length.
struct Piece {
  Vec2 from, to;
  std::uint32_t feature = 0;
};

double distance(Vec2 p, const Piece& piece) {
  const Vec2 along = piece.to - piece.from;
  const double square = dot(along, along);
  const double t = square > 0 ? std::clamp(dot(p - piece.from, along) / square, 0.0, 1.0) : 0.0;
  return norm(p - (piece.from + along * t));
}

double distance(const Piece& a, const Piece& b) {
  const double ends = std::min({distance(a.from, b), distance(a.to, b), distance(b.from, a), distance(b.to, a)});
  const Vec2 u = a.to - a.from, v = b.to - b.from;
  const double left = cross(u, b.from - a.from), right = cross(u, b.to - a.from);
  const double ahead = cross(v, a.from - b.from), behind = cross(v, a.to - b.from);
  const bool crossing = left * right < 0 && ahead * behind < 0;
  return crossing ? 0 : ends;
}

/// All features in pieces that are not much longer than a cell of the grid.
class Pieces {
 public:
  explicit Pieces(const Recipe& recipe) {
    constexpr double kLeast_mm = 2, kMostCells = 200000;
    double all = 0;
    for (const Feature& f : recipe.features)
      if (const auto* bead = std::get_if<Bead>(&f)) all += length_of(bead->points);
    cell_mm_ = std::max(kLeast_mm, all / kMostCells);
    for (std::size_t i = 0; i < recipe.features.size(); ++i) {
      if (const auto* one = std::get_if<Dot>(&recipe.features[i])) add({one->at, one->at, std::uint32_t(i)});
      if (const auto* bead = std::get_if<Bead>(&recipe.features[i]))
        for (std::size_t k = 1; k < bead->points.size(); ++k)
          cut({flat(bead->points[k - 1]), flat(bead->points[k]), std::uint32_t(i)});
    }
  }

  /// Calls `near(a, b)` with two features that are asked about and have pieces nearer than kLayer_mm, perhaps more than
  /// once. False: it has said no, or there is too much to look at.
  template <class Asked, class Near>
  bool pairs(Asked&& asked, Near&& near) const {
    std::size_t looks = 0;
    for (const auto& [cell, inside] : cells_)
      for (std::size_t i = 0; i < inside.size(); ++i)
        for (std::size_t k = i + 1; k < inside.size(); ++k) {
          const Piece &a = pieces_[inside[i]], &b = pieces_[inside[k]];
          if (++looks > kMostLooks) return false;
          if (asked(a.feature, b.feature) && distance(a, b) < kLayer_mm && !near(a.feature, b.feature)) return false;
        }
    return true;
  }

 private:
  void cut(const Piece& whole) {
    const Vec2 along = whole.to - whole.from;
    const int parts = std::max(1, static_cast<int>(std::ceil(norm(along) / cell_mm_)));
    for (int i = 0; i < parts; ++i)
      add({whole.from + along * (double(i) / parts), whole.from + along * (double(i + 1) / parts), whole.feature});
  }
  /// Two pieces that are as near as a layer have a cell in common: each lies in all that its box, grown by half of
  /// that, reaches.
  void add(const Piece& piece) {
    const auto index = static_cast<std::uint32_t>(pieces_.size());
    pieces_.push_back(piece);
    const auto cell = [&](double v) { return static_cast<std::int32_t>(std::floor(v / cell_mm_)); };
    constexpr double kHalf_mm = kLayer_mm / 2;
    for (auto x = cell(std::min(piece.from.x, piece.to.x) - kHalf_mm);
         x <= cell(std::max(piece.from.x, piece.to.x) + kHalf_mm); ++x)
      for (auto y = cell(std::min(piece.from.y, piece.to.y) - kHalf_mm);
           y <= cell(std::max(piece.from.y, piece.to.y) + kHalf_mm); ++y)
        cells_[std::pair(x, y)].push_back(index);
  }

  double cell_mm_ = 0;
  std::vector<Piece> pieces_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<std::uint32_t>> cells_;
};

}  // namespace

bool Precedence::none() const {
  const auto empty = [](const auto& list) { return list.empty(); };
  return std::all_of(rows.begin(), rows.end(), empty) && std::all_of(features.begin(), features.end(), empty);
}

Precedence by_rows(std::vector<std::vector<std::uint32_t>> after, std::vector<std::uint32_t> row_of) {
  Precedence before{std::move(row_of), std::move(after), {}};
  before.features.resize(before.row.size());
  return before;
}

MayCome::MayCome(const Precedence& before)
    : row_(before.row),
      in_row_(before.rows.size()),
      rows_behind_(before.rows.size()),
      behind_(before.row.size()),
      waits_(before.row.size()),
      left_(before.rows.size()),
      row_waits_(before.rows.size()) {
  for (std::uint32_t f = 0; f < row_.size(); ++f) {
    in_row_[row_[f]].push_back(f), ++left_[row_[f]];
    waits_[f] = before.features[f].size() + (before.rows[row_[f]].empty() ? 0 : 1);
    for (const std::uint32_t first : before.features[f]) behind_[first].push_back(f);
  }
  for (std::uint32_t row = 0; row < before.rows.size(); ++row) {
    row_waits_[row] = before.rows[row].size();
    for (const std::uint32_t first : before.rows[row]) rows_behind_[first].push_back(row);
  }
  std::vector<std::uint32_t> freed;
  for (std::uint32_t row = 0; row < before.rows.size(); ++row)
    if (in_row_[row].empty() && before.rows[row].empty()) row_came(row, freed);
}

void MayCome::came(std::uint32_t feature, std::vector<std::uint32_t>& freed) {
  freed.clear();
  for (const std::uint32_t next : behind_[feature]) one_less(next, freed);
  if (--left_[row_[feature]] == 0) row_came(row_[feature], freed);
}

void MayCome::row_came(std::uint32_t first, std::vector<std::uint32_t>& freed) {
  std::vector<std::uint32_t> all{first};  // and rows without a feature behind it
  while (!all.empty()) {
    const std::uint32_t row = all.back();
    all.pop_back();
    for (const std::uint32_t next : rows_behind_[row]) {
      if (--row_waits_[next] > 0) continue;
      for (const std::uint32_t f : in_row_[next]) one_less(f, freed);
      if (in_row_[next].empty()) all.push_back(next);
    }
  }
}

void MayCome::one_less(std::uint32_t feature, std::vector<std::uint32_t>& freed) {
  if (--waits_[feature] == 0) freed.push_back(feature);
}

namespace {

/// The lowest feature first of those that wait for none, so that rows stay whole. With `wishes` (of each feature others
/// that would better come before it) first those whose wishes are met, too.
std::vector<std::size_t> lowest_first(const Precedence& before, std::span<const std::vector<std::uint32_t>> wishes) {
  const auto count = static_cast<std::uint32_t>(before.row.size());
  std::vector<std::vector<std::uint32_t>> wished_of(count);
  std::vector<std::size_t> unmet(count);
  for (std::uint32_t f = 0; f < wishes.size(); ++f)
    for (const std::uint32_t first : wishes[f]) wished_of[first].push_back(f), ++unmet[f];
  MayCome may(before);
  std::set<std::uint32_t> ready, reluctant;
  const auto take_in = [&](std::uint32_t f) { (unmet[f] == 0 ? ready : reluctant).insert(f); };
  for (std::uint32_t f = 0; f < count; ++f)
    if (may.is_free(f)) take_in(f);
  std::vector<std::size_t> order;
  order.reserve(count);
  std::vector<std::uint32_t> freed;
  while (!ready.empty() || !reluctant.empty()) {
    auto& from = ready.empty() ? reluctant : ready;
    const std::uint32_t f = *from.begin();
    from.erase(from.begin());
    order.push_back(f);
    for (const std::uint32_t next : wished_of[f])
      if (--unmet[next] == 0 && reluctant.erase(next) > 0) ready.insert(next);
    may.came(f, freed);
    for (const std::uint32_t next : freed) take_in(next);
  }
  return order;
}

}  // namespace

std::vector<std::size_t> in_rows(const Precedence& before) { return lowest_first(before, {}); }

Result<void> keep_layers(const Recipe& recipe, Precedence& before) {
  const auto material = [&](std::uint32_t f) -> const std::string& {
    return std::visit([](const auto& each) -> const std::string& { return each.material; }, recipe.features[f]);
  };
  std::unordered_map<std::string_view, std::uint32_t> numbers;
  std::vector<std::uint32_t> number(recipe.features.size());
  for (std::uint32_t f = 0; f < number.size(); ++f)
    number[f] = numbers.emplace(material(f), static_cast<std::uint32_t>(numbers.size())).first->second;
  if (numbers.size() < 2) return {};
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;  // the one that stands later in the file, the other
  const bool all = Pieces(recipe).pairs([&](std::uint32_t a, std::uint32_t b) { return number[a] != number[b]; },
                                        [&](std::uint32_t a, std::uint32_t b) {
                                          found.emplace_back(std::max(a, b), std::min(a, b));
                                          return found.size() < kMostPairs;
                                        });
  if (!all)
    return fail(Fault::TooManySteps,
                fmt::format("with `order: shortest` too many features of different materials lie within {:.6g} mm of "
                            "each other; split the recipe, or leave the order to the file",
                            kLayer_mm));
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  // `after` may turn some of them round: an order that keeps it, and as many of them as it can, says which.
  std::vector<std::vector<std::uint32_t>> wishes(before.row.size());
  for (const auto& [feature, first] : found) wishes[feature].push_back(first);
  const std::vector<std::size_t> order = lowest_first(before, wishes);
  std::vector<std::size_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  for (const auto& [feature, first] : found) {
    const bool kept = place[first] < place[feature];
    before.features[kept ? feature : first].push_back(kept ? first : feature);
  }
  return {};
}

}  // namespace gantry::recipes
