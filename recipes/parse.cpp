#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "core/near_word.hpp"
#include "core/sha256.hpp"
#include "recipes/after.hpp"
#include "recipes/board_size.hpp"
#include "recipes/expand.hpp"
#include "recipes/on_board.hpp"
#include "recipes/points_file.hpp"
#include "recipes/precedence.hpp"
#include "recipes/recipe_file.hpp"
#include "recipes/shortest.hpp"
#include "recipes/travel.hpp"
#include "recipes/twice.hpp"

namespace gantry::recipes {
namespace {

using config::Mistakes;
using written::FeatureRow;

/// What can be judged without a machine, but for the geometry of features (expand.hpp): names, and what is on the
/// board.
class Checker {
 public:
  /// `names_read`: what is not in the recipe by its name was not written either.
  Checker(const Recipe& recipe, bool names_read, Mistakes& mistakes)
      : recipe_(recipe), names_read_(names_read), mistakes_(mistakes) {}

  void board_items() {
    for (const MarkDef& m : recipe_.marks) {
      require_on_board(recipe_.board, m.at, m.location, "mark", mistakes_);
      for (const Part& p : recipe_.parts)
        if (!p.unread && covers(p, m.at, m.diameter / 2))
          mistakes_.add(Fault::Inconsistent, fmt::format("'{}' covers the mark: the camera looks from above", p.name),
                        m.location);
    }
    marks_fix_an_offset();
    if (recipe_.placement == Placement::Fixture && !recipe_.marks.empty())
      mistakes_.add(
          Fault::Inconsistent,
          "`placement: fixture` says that the board lies at its nominal placement, and marks measure where it "
          "lies; leave out one of them",
          recipe_.marks.front().location);
    for (const TouchPoint& t : recipe_.touches)
      require_on_board(recipe_.board, t.at, t.location, "touch point", mistakes_);
    touches_tell_enough();
    std::set<std::string> names;
    for (const Part& p : recipe_.parts) {
      if (!names.insert(p.name).second)
        mistakes_.add(Fault::DuplicateKey, fmt::format("a part and a fixture are both called '{}'", p.name),
                      p.location);
      if (!p.fixture && !p.unread) require_on_board(recipe_.board, p.at, p.location, "part", mistakes_);
    }
  }

  void purge() {
    if (!recipe_.purge) return;
    const Purge& purge = *recipe_.purge;
    if (purge.material_location.line > 0 && !purge.material.empty()) material(purge.material, purge.material_location);
    if (!purge.frame.empty() || purge.at_location.line == 0) return;
    require_on_board(recipe_.board, flat(purge.at), purge.at_location, "point", mistakes_);
    if (purge.at.z < 0)
      mistakes_.add(Fault::OutOfRange, "nothing lies below the board's top face; write a height of 0 mm or more",
                    purge.at_location);
  }

  void feature(const FeatureRow& row) {
    if (row.name.given() && !names_.insert(row.name.value).second)
      mistakes_.add(Fault::DuplicateKey, fmt::format("another feature is called '{}' already", row.name.value),
                    row.name.location);
    if (row.material.given()) material(row.material.value, row.material.location);
  }

  /// Once for each name, when all features were looked at.
  void missing_materials() {
    std::vector<std::string_view> known;
    for (const Material& m : recipe_.materials) known.push_back(m.name);
    for (const auto& [name, found] : missing_) {
      const std::string near(nearest(name, known));
      if (!names_read_ && near.empty()) continue;  // it may be one that was not read
      if (const Material* meant = find_material(recipe_, near); meant && found.second > 1 && !used_.contains(near)) {
        mistakes_.add(Fault::UnknownReference,
                      fmt::format("material '{}' is used by nothing, and '{}', which is not here, {} times; {}", near,
                                  name, found.second, did_you_mean(name)),
                      meant->location);
        continue;
      }
      mistakes_.add(Fault::UnknownReference,
                    fmt::format("there is no material '{}'{}; {}", name,
                                found.second > 1 ? fmt::format(" (here and {} times more)", found.second - 1) : "",
                                did_you_mean(name, known)),
                    found.first);
    }
  }

 private:
  /// The camera takes marks that overlap for one.
  void marks_fix_an_offset() {
    for (std::size_t i = 0; i < recipe_.marks.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const MarkDef &a = recipe_.marks[k], &b = recipe_.marks[i];
        if (norm(a.at - b.at) < (a.diameter + b.diameter) / 2)
          mistakes_.add(
              Fault::Inconsistent,
              fmt::format("mark '{}' overlaps mark '{}'; two marks on one spot fix no offset", b.name, a.name),
              b.location);
      }
  }
  void material(const std::string& name, Location location) {
    if (find_material(recipe_, name)) return void(used_.insert(name));
    if (recipe_.materials.empty()) return;  // that they are missing is told already
    auto& [first, times] = missing_.try_emplace(name, location, 0).first->second;
    first = std::min(first, location);
    ++times;
  }
  /// False, and a mistake, where one reads what another one has read.
  bool touches_apart() {
    constexpr double kSameSpot_mm = 0.5;  // as far as a stylus presses the surface
    bool apart = true;
    for (std::size_t i = 0; i < recipe_.touches.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const TouchPoint &a = recipe_.touches[k], &b = recipe_.touches[i];
        if (norm(a.at - b.at) >= kSameSpot_mm) continue;
        mistakes_.add(Fault::Inconsistent,
                      fmt::format("touch '{}' is at the same place as touch '{}' and tells nothing new; move one of "
                                  "them, or leave it out",
                                  b.name, a.name),
                      b.location);
        apart = false;
        break;
      }
    return apart;
  }
  /// Three touches and more are meant to measure the tilt in both directions; on one line they cannot. Where the plane
  /// is told by others, one that is touched twice does no harm.
  void touches_tell_enough() {
    constexpr double kWidth = 0.1;  // of the line's length; nearer to it, the touches' errors turn the plane about it
    if (recipe_.touches.size() < 3) return void(touches_apart());
    const Vec2 from = recipe_.touches.front().at;
    const auto farthest = std::max_element(recipe_.touches.begin(), recipe_.touches.end(),
                                           [&](auto& a, auto& b) { return norm(a.at - from) < norm(b.at - from); });
    const Vec2 along = farthest->at - from;
    const double length = norm(along);
    double width = 0;
    for (const TouchPoint& t : recipe_.touches)
      if (length > 0) width = std::max(width, std::abs(dot(Vec2{-along.y, along.x}, t.at - from)) / length);
    if ((width < kWidth * length || length == 0) && touches_apart())
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("the {} touches lie on one line, so the tilt across it stays unmeasured; put one at "
                                "least {:.6g} mm beside it",
                                recipe_.touches.size(), std::max(1.0, kWidth * length)),
                    recipe_.touches.back().location);
  }
  /// A part, or a fixture with the board in its nominal placement, over any point of a disc.
  [[nodiscard]] static bool covers(const Part& part, Vec2 at, double radius) {
    const Vec2 p = rotated(at - part.at, -part.rotation);
    const Vec2 beyond{std::max(0.0, std::abs(p.x) - part.size.x / 2), std::max(0.0, std::abs(p.y) - part.size.y / 2)};
    return norm(beyond) < radius;
  }
  const Recipe& recipe_;
  const bool names_read_;
  std::set<std::string> used_;                                       ///< materials
  std::map<std::string, std::pair<Location, std::size_t>> missing_;  ///< materials: where first, and how often
  Mistakes& mistakes_;
  std::set<std::string> names_;
};

/// Of a recipe without mistakes.
Result<std::vector<std::size_t>> short_sequence(const Recipe& recipe, Precedence before) {
  if (auto kept = keep_layers(recipe, before); !kept) return tl::unexpected(kept.error());
  return shortest_order(ends_of(recipe), before);
}

Checked<Recipe> whole(written::Draft draft) {
  if (!draft.mistakes.empty()) return tl::unexpected(std::move(draft.mistakes));
  return std::move(draft.recipe);
}

}  // namespace

Result<written::Draft> written::draft_file(const std::string& path) {
  const auto text = config::read_text_file(path);
  if (!text) return tl::unexpected(text.error());
  return draft(*text, path, [&path](const std::string& name) { return read_beside(path, name); });
}

written::Draft written::draft(std::string_view yaml, std::string_view file, const ReadText& beside) {
  Mistakes mistakes{std::string(file)};
  auto read = config::read_fields(yaml, recipe_fields(), mistakes, "a recipe");
  if (!read) return {{}, false, mistakes.errors()};
  const bool all_read = mistakes.none();  // else what is not in the recipe may only not have been read
  Recipe recipe = std::move(read->recipe);
  recipe.file = file;
  recipe.sources.push_back({recipe.file, yaml.size(), sha256_hex(yaml)});
  if (size_is_wrong(recipe, read->features, mistakes)) recipe.board.size = {};
  const std::vector<Error> in_text = mistakes.errors();
  const bool names_read = std::ranges::none_of(
      in_text, [](const Error& e) { return e.fault == Fault::YamlSyntax || e.fault == Fault::DuplicateKey; });
  Checker check(recipe, names_read, mistakes);
  check.board_items();
  check.purge();
  Expander expander(recipe, mistakes, beside, all_read);
  std::vector<std::uint32_t> row_of;  // of each feature
  std::size_t looked_at = 0;
  for (; looked_at < read->features.size() && !expander.full(); ++looked_at) {
    check.feature(read->features[looked_at]);
    expander.add(read->features[looked_at]);
    row_of.resize(recipe.features.size(), static_cast<std::uint32_t>(looked_at));
  }
  check.missing_materials();
  auto before = rows_before(read->features, recipe.order, all_read, mistakes);
  const std::vector<Error> in_files = expander.mistakes_in_files();
  if (mistakes.none() && in_files.empty()) check_twice(recipe, mistakes);
  if (mistakes.none() && in_files.empty() && recipe.order == Order::Shortest) {
    auto sequence = short_sequence(recipe, by_rows(std::move(before), std::move(row_of)));
    if (sequence)
      recipe.sequence = *std::move(sequence);
    else
      mistakes.add(sequence.error().fault, sequence.error().message, read->features.front().location);
  }
  std::vector<Error> all = mistakes.errors();
  all.insert(all.end(), in_files.begin(), in_files.end());
  if (const std::size_t left = read->features.size() - looked_at; left > 0)
    all.push_back({Fault::BadValue, fmt::format("{} of its features were not looked at; mend what is told first", left),
                   recipe.file});
  return {std::move(recipe), true, std::move(all)};
}

Checked<Recipe> parse(std::string_view yaml, std::string_view file, const ReadText& beside) {
  return whole(written::draft(yaml, file, beside));
}

Checked<Recipe> load(const std::string& path) {
  auto draft = written::draft_file(path);
  if (!draft) return tl::unexpected(std::vector{draft.error()});
  return whole(*std::move(draft));
}

std::vector<std::size_t> sequence_of(const Recipe& recipe) {
  if (!recipe.sequence.empty()) return recipe.sequence;
  std::vector<std::size_t> as_they_stand(recipe.features.size());
  std::iota(as_they_stand.begin(), as_they_stand.end(), std::size_t{0});
  return as_they_stand;
}

double upright_tolerance_mm(double corner_tolerance_mm, const Material& material) {
  return std::min({corner_tolerance_mm, material.gap_tolerance_mm, material.gap / 2});
}

double length_mm(const Bead& bead) {
  if (bead.curve_mm > 0) return bead.curve_mm;
  return length_of(bead.points);
}

const Material* find_material(const Recipe& recipe, std::string_view name) {
  for (const Material& material : recipe.materials)
    if (material.name == name) return &material;
  return nullptr;
}

double override_max(const Recipe& recipe) {
  std::optional<double> most;
  const auto dispensed = [&](const std::string& name) {
    if (const Material* m = find_material(recipe, name))
      most = std::min(most.value_or(m->override_max), m->override_max);
  };
  if (recipe.purge) dispensed(recipe.purge->material);
  for (const Feature& feature : recipe.features) std::visit([&](const auto& f) { dispensed(f.material); }, feature);
  return most.value_or(1);
}

}  // namespace gantry::recipes
