// From a feature as it is written to dots and beads: arrays, curves and fills become points, files of points are read.
//   Expander expander(recipe, mistakes, beside);
//   for (const written::FeatureRow& row : rows) expander.add(row);      // recipe.features, fills and sources grow
//   expander.mistakes_in_files();                                       // of files of points, each with its own lines
// Geometry that cannot be meant is told where it is written.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "recipes/recipe_file.hpp"

namespace gantry::recipes {

class Expander {
 public:
  /// All outlive it. The board, and the recipe's own file in `sources`, are known.
  /// `all_read`: what is not in the recipe was not written either.
  Expander(Recipe& to, config::Mistakes& mistakes, const ReadText& beside, bool all_read = true)
      : to_(to), mistakes_(mistakes), beside_(beside), all_read_(all_read) {}

  void add(const written::FeatureRow& row);
  /// No more is looked at: the recipe holds too much, or too many mistakes.
  [[nodiscard]] bool full() const { return full_ || mistakes_.full() || told_in_files_ >= config::Mistakes::kMost; }
  [[nodiscard]] std::vector<Error> mistakes_in_files() const;

 private:
  /// What points are judged by.
  struct Judge {
    bool on_board = true, apart = true, open_end = true;
  };
  /// A file of points, read once however many features name it.
  struct PointsFile {
    std::optional<Error> unreadable{};
    std::vector<config::At<Vec3>> points{};
    config::Mistakes mistakes;
    Judge left{};          ///< by what it was not judged yet
    std::size_t told = 0;  ///< of its mistakes
  };

  void expand(const written::FeatureRow& row);
  /// Raises what was added last onto the part that it is dispensed on.
  void put_on_part(const written::FeatureRow& row, std::size_t first);
  void dot(const written::FeatureRow& row);
  void array(const written::FeatureRow& row);
  void line(const written::FeatureRow& row);
  void polyline(const written::FeatureRow& row);
  void rectangle(const written::FeatureRow& row);
  void arc(const written::FeatureRow& row);
  void circle(const written::FeatureRow& row);
  void spiral(const written::FeatureRow& row);
  void fill(const written::FeatureRow& row);

  /// Which group of keys is written: 0, 1; -1 and a mistake when it is neither, both, or half of one.
  int group(const written::FeatureRow& row, std::vector<const char*> first, std::vector<const char*> second);
  /// Points of a file beside the recipe, judged like those of a recipe.
  std::vector<Vec3> from_file(const written::FeatureRow& row);
  /// The index of its file in files_.
  std::size_t file_named(const std::string& name);
  void read(const std::string& name, PointsFile& to);
  /// On the board, no point twice in a row (`apart`), and no superfluous last one (`open_end`).
  void judge(const std::vector<config::At<Vec3>>& points, Judge by, config::Mistakes& mistakes) const;
  /// On the board, unless the feature may leave it.
  bool require(Vec2 p, Location location, std::string_view what, config::Mistakes& mistakes) const;
  /// Of points that are worked out: the first that leaves the board.
  bool stays_on_board(const std::vector<Vec3>& points, Location location, std::string_view what);
  void add_curve(const written::FeatureRow& row, Result<struct Curve> curve, const char* kind, bool closed);
  void add_bead(Bead bead);
  [[nodiscard]] std::size_t points_left() const;

  Recipe& to_;
  config::Mistakes& mistakes_;
  const ReadText& beside_;
  std::vector<PointsFile> files_;
  std::map<std::string, std::size_t> file_of_;  ///< by the name that the recipe gives it
  std::size_t bytes_of_files_ = 0, told_in_files_ = 0;
  std::size_t points_ = 0;  ///< of all beads
  bool full_ = false;
  const bool all_read_;
  bool off_board_ = false;  ///< the feature that is looked at may leave the board ...
  std::string name_;        ///< ... and is called this
};

}  // namespace gantry::recipes
