#include "recipes/recipe_file.hpp"

namespace gantry::recipes {
namespace written {
namespace {

// Not a using-directive: config has a Place and a Shape of its own.
using config::Fields;
using config::flag;
using config::integer;
using config::kOptional;
using config::kRequired;
using config::list_of_variants;
using config::Mistakes;
using config::name_of;
using config::named;
using config::Need;
using config::Node;
using config::number;
using config::object;
using config::point;
using config::points;
using config::Range;
using config::ValueShape;
using D = config::Dimension;

constexpr Range kOnBoard{-2000, 2000}, kExtent{0.01, 2000};
constexpr Range kHalfTurn{units::rad(-180), units::rad(180)}, kTurn{units::rad(-360), units::rad(360)};

/// The machine is asked for it later: a mistake is told where it stands.
config::Field<Board> frame() {
  auto inner = name_of("frame", &Board::frame, kRequired, "a frame of the machine");
  return {inner.row, [inner](const Node& node, Board& to, Mistakes& mistakes) {
            inner.read(node, to, mistakes);
            to.frame_place = node.place;
          }};
}

const Fields<Board> kBoard{
    point("size", &Board::size, kExtent, kRequired, "its edges along X and Y"),
    number("thickness", &Board::thickness, D::Length, {0.01, 500}, kRequired,
           "its top face stands this far above the frame's origin"),
    frame(),
    point("at", &Board::at, kOnBoard, kOptional, "nominal place of its origin in that frame"),
    number("clamp_margin", &Board::clamp_margin, D::Length, {0, 100}, kOptional,
           "kept free at the edges by the fixture"),
};

const Fields<Part> kPart{
    point("at", &Part::at, kOnBoard, kRequired, "its centre"),
    point("size", &Part::size, kExtent, kRequired, "its edges; the last is its height over the board"),
    number("rotation", &Part::rotation, D::Angle, kHalfTurn, kOptional, "counter-clockwise"),
};
const Fields<Part> kFixture{
    point("at", &Part::at, kOnBoard, kRequired, "its centre, with the board in its nominal place"),
    point("size", &Part::size, kExtent, kRequired, "its edges; the last is its height over the frame's origin"),
    number("rotation", &Part::rotation, D::Angle, kHalfTurn, kOptional, "counter-clockwise"),
};

const Fields<MarkDef> kMark{
    point("at", &MarkDef::at, kOnBoard, kRequired, "its centre"),
    number("diameter", &MarkDef::diameter, D::Length, {0.1, 50}, kRequired, "of the disc"),
    flag("bright", &MarkDef::bright, kOptional, "brighter than the board"),
};
const Fields<MarkRules> kMarkRules{
    number("max_residual", &MarkRules::max_residual_mm, D::Length, {0.001, 5}, kOptional, "marks may disagree by this"),
    number("max_shift", &MarkRules::max_shift_mm, D::Length, {0.01, 50}, kOptional, "the board may lie this far off"),
    number("max_rotation", &MarkRules::max_rotation_rad, D::Angle, {units::rad(0.1), units::rad(45)}, kOptional,
           "the board may be turned by this"),
    integer("attempts", &MarkRules::attempts, {1, 10}, kOptional, "pictures of a mark before it counts as missing"),
};

const Fields<TouchPoint> kTouch{
    point("at", &TouchPoint::at, kOnBoard, kRequired, "where the probe touches the board"),
};
const Fields<TouchRules> kTouchRules{
    number("max_residual", &TouchRules::max_residual_mm, D::Length, {0.001, 5}, kOptional,
           "more than three touches may disagree by this"),
    number("window", &TouchRules::window_mm, D::Length, {0.01, 50}, kOptional,
           "the surface is within +- this of nominal"),
};

const Fields<Material> kMaterial{
    number("speed", &Material::speed, D::Speed, {0.1, 1000}, kRequired, "path speed of a bead"),
    number("gap", &Material::gap, D::Length, {0.01, 20}, kRequired, "between needle and surface"),
    number("valve_open_lead", &Material::valve_open_lead, D::Time, {0, 0.5}, kRequired,
           "the valve is opened this long before the needle is there"),
    number("valve_close_lead", &Material::valve_close_lead, D::Time, {0, 0.5}, kRequired,
           "the valve is closed this long before the end"),
    number("dot_time", &Material::dot_time, D::Time, {0.001, 10}, kRequired, "the valve is open this long on a dot"),
    number("settle_time", &Material::settle_time, D::Time, {0, 10}, kOptional, "standstill before a dot"),
    number("retract", &Material::retract, D::Length, {0, 100}, kRequired, "the needle lifts by this after a feature"),
};

const auto kName = name_of("name", &FeatureRow::name, kRequired, "its own name; reports and messages use it");
const auto kOf = name_of("material", &FeatureRow::material, kRequired, "one of `materials`");
const auto kCorner = number("corner_tolerance", &FeatureRow::corner_tolerance, D::Length, {0, 5}, kOptional,
                            "corners may be rounded by this; 0: stop in each");
const auto kRotation =
    number("rotation", &FeatureRow::rotation, D::Angle, kTurn, kOptional, "counter-clockwise about `at`");

config::Field<FeatureRow> skipped() {
  ValueShape index{ValueShape::Kind::Integer, {}, {0, 9999}, {}, {}, {}};
  ValueShape pair{ValueShape::Kind::Tuple, {}, config::kAny, {}, {}, {index, index}};
  ValueShape shape{ValueShape::Kind::List, {}, {0, 10000}, {}, {}, {pair}};
  return {{"skip", kOptional, "[row, column] of what is left out, from 0", shape},
          [index, shape](const Node& node, FeatureRow& to, Mistakes& mistakes) {
            if (!config::expect_list(node, shape.range, mistakes)) return;
            for (const Node& item : node.items) {
              if (!config::expect_list(item, {2, 2}, mistakes)) continue;
              const auto row = config::read_integer(item.items[0], index, mistakes);
              const auto column = config::read_integer(item.items[1], index, mistakes);
              if (!row || !column) continue;
              if (*row >= to.rows || *column >= to.columns)
                mistakes.add(Fault::OutOfRange, "no such row or column in the array; both count from 0", item.place);
              to.skip.emplace_back(static_cast<int>(*row), static_cast<int>(*column));
            }
          }};
}

std::vector<config::Variant<FeatureRow>> feature_kinds() {
  const auto tag = [](FeatureKind kind) { return [kind](FeatureRow& row) { row.kind = kind; }; };
  return {
      {"dot",
       "one shot",
       tag(FeatureKind::Dot),
       {kName, kOf, point("at", &FeatureRow::at, kOnBoard, kRequired, "where")}},
      {"array",
       "dots in rows and columns",
       tag(FeatureKind::Array),
       {kName, kOf, point("at", &FeatureRow::at, kOnBoard, kRequired, "the dot of row 0, column 0"),
        integer("rows", &FeatureRow::rows, {1, 10000}, kRequired, "along Y"),
        integer("columns", &FeatureRow::columns, {1, 10000}, kRequired, "along X"),
        point("pitch", &FeatureRow::pitch, {-1000, 1000}, kRequired, "from column to column, from row to row"),
        kRotation, skipped()}},
      {"line",
       "a straight bead",
       tag(FeatureKind::Line),
       {kName, kOf, point("from", &FeatureRow::at, kOnBoard, kRequired, "its start"),
        point("to", &FeatureRow::to, kOnBoard, kRequired, "its end")}},
      {"polyline",
       "a bead along points",
       tag(FeatureKind::Polyline),
       {kName, kOf, points("points", &FeatureRow::points, {2, 10000}, kOnBoard, kRequired, "in their order"), kCorner,
        flag("closed", &FeatureRow::closed, kOptional, "goes back to its first point")}},
      {"rectangle",
       "a closed bead",
       tag(FeatureKind::Rectangle),
       {kName, kOf, point("at", &FeatureRow::at, kOnBoard, kRequired, "its corner, where the bead starts and ends"),
        point("size", &FeatureRow::size, kExtent, kRequired, "its edges along X and Y"), kRotation, kCorner}},
  };
}

/// A field of Recipe as a field of the file.
template <class U>
config::Field<RecipeFile> of_recipe(config::Field<U> inner) {
  return {inner.row,
          [inner](const Node& node, RecipeFile& to, Mistakes& mistakes) { inner.read(node, to.recipe, mistakes); }};
}

/// Fixtures are parts that stay where they are.
config::Field<RecipeFile> fixtures() {
  auto inner = named("fixtures", &Recipe::parts, kFixture, {0, 1000}, kOptional,
                     "what stands on the pallet near the board: clamps");
  return {inner.row, [inner](const Node& node, RecipeFile& to, Mistakes& mistakes) {
            const std::size_t first = to.recipe.parts.size();
            inner.read(node, to.recipe, mistakes);
            for (std::size_t i = first; i < to.recipe.parts.size(); ++i) to.recipe.parts[i].fixture = true;
          }};
}

}  // namespace

const Fields<RecipeFile>& recipe_fields() {
  static const Fields<RecipeFile> kFields{
      config::format_version<RecipeFile>(1),
      of_recipe(name_of("recipe", &Recipe::name, kRequired, "its name")),
      of_recipe(object("board", &Recipe::board, kBoard, kRequired, "what lies on the machine")),
      of_recipe(named("parts", &Recipe::parts, kPart, {0, 1000}, kOptional, "what stands on the board")),
      fixtures(),
      of_recipe(named(
          "marks", &Recipe::marks, kMark, {2, 100}, kOptional,
          "fiducials; at least two, three to trust them; without them the board is taken to lie at its nominal place")),
      of_recipe(object("mark_rules", &Recipe::mark_rules, kMarkRules, kOptional, "when marks are believed")),
      of_recipe(
          named("touches", &Recipe::touches, kTouch, {1, 100}, kOptional,
                "where the height is probed; three give a plane; without them the height is taken to be nominal")),
      of_recipe(object("touch_rules", &Recipe::touch_rules, kTouchRules, kOptional, "when touches are believed")),
      of_recipe(named("materials", &Recipe::materials, kMaterial, {1, 100}, kRequired, "what is dispensed, and how")),
      list_of_variants("features", &RecipeFile::features, feature_kinds(), {1, 100000}, kRequired,
                       "what is dispensed where, in this order"),
  };
  return kFields;
}

}  // namespace written

const std::vector<config::FieldShape>& recipe_format() {
  static const std::vector<config::FieldShape> kFormat = config::object_shape(written::recipe_fields()).fields;
  return kFormat;
}

}  // namespace gantry::recipes
