// A recipe's features as they are written, before arrays and rectangles are expanded. parse.cpp makes a Recipe of them.
#pragma once
#include "config/fields.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes::written {

using config::At;

enum class FeatureKind { Dot, Array, Line, Polyline, Rectangle };

/// One row for every kind; what a kind does not have stays at its default.
struct FeatureRow {
  FeatureKind kind = FeatureKind::Dot;
  Place place;  ///< of the key that names the kind
  At<std::string> name, material;
  At<Vec2> at, to, size, pitch;
  std::vector<At<Vec2>> points;
  int rows = 0, columns = 0;
  std::vector<std::pair<int, int>> skip;
  double rotation = 0, corner_tolerance = 0;
  bool closed = false;
};

struct RecipeFile {
  Recipe recipe;  ///< all but the features
  Place board_size;
  std::vector<FeatureRow> features;
};

const config::Fields<RecipeFile>& recipe_fields();

}  // namespace gantry::recipes::written

namespace gantry::recipes {

/// The format of recipes/*.yaml, for its schema and docs.
const std::vector<config::FieldShape>& recipe_format();

}  // namespace gantry::recipes
