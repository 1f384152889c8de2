// A recipe's features as they are written, before arrays, curves and fills are expanded. parse.cpp makes a Recipe of
// them.
#pragma once
#include "config/fields.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes::written {

using config::At;

enum class FeatureKind { Dot, Array, Line, Polyline, Rectangle, Arc, Circle, Spiral, Fill };

/// One row for every kind; what a kind does not have stays at its default.
struct FeatureRow {
  FeatureKind kind = FeatureKind::Dot;
  Location location;              ///< of the key that names the kind
  std::vector<std::string> keys;  ///< that are written, whether or not they could be read
  At<std::string> name, material, on;
  std::vector<At<std::string>> after;  ///< names of features
  At<Vec3> at, to, through, centre;
  At<Vec2> size, pitch;
  std::vector<At<Vec3>> points;
  At<std::string> points_file;
  int rows = 0, columns = 0;
  std::vector<std::pair<int, int>> skip;
  double rotation = 0, corner_tolerance = 0;
  double curve_tolerance = 0.05;      ///< corner tolerance of the chords of a curve
  At<double> angle;                   ///< of an arc
  At<double> from_radius, to_radius;  ///< a circle has the first alone
  At<double> spacing;                 ///< of the turns of a spiral, of the lines of a fill
  double start_angle = 0;             ///< of a circle, of a spiral
  double line_angle = 0;              ///< of a fill
  bool closed = false, clockwise = false, serpentine = true;
  bool off_board = false;
  bool unread = false;  ///< something of it is a mistake, so that its geometry tells nothing
};

struct RecipeFile {
  Recipe recipe;  ///< all but the features
  std::vector<FeatureRow> features;
};

const config::Fields<RecipeFile>& recipe_fields();

/// A recipe as far as it could be read, and every mistake in it.
struct Draft {
  Recipe recipe;
  bool readable = false;  ///< false: it is no YAML, and `recipe` is empty
  std::vector<Error> mistakes;
};
Draft draft(std::string_view yaml, std::string_view file, const ReadText& beside);
/// Of a file, with its files of points beside it.
Result<Draft> draft_file(const std::string& path);

}  // namespace gantry::recipes::written

namespace gantry::recipes {

/// The format of recipes/*.yaml, for its schema and docs.
const std::vector<config::FieldShape>& recipe_format();

}  // namespace gantry::recipes
