#include "recipes/recipe_file.hpp"

#include "recipes/fill.hpp"
#include "recipes/points_file.hpp"

namespace gantry::recipes {
namespace written {
namespace {

// Not a using-directive: config has a Location and a Shape of its own.
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
using config::Range;
using config::spot;
using config::spots;
using config::ValueShape;
using D = config::Dimension;

constexpr Range kExtent{0.01, 2000}, kRadius{0.01, 1000}, kSpacing{0.01, 1000};
constexpr double kMostParts = 5000;  // and as many fixtures
constexpr Range kHalfTurn{units::rad(-180), units::rad(180)}, kTurn{units::rad(-360), units::rad(360)};

/// What is judged later, when a mistake in it is told where it stands.
template <class T>
config::Field<T> noted(config::Field<T> inner, Location T::*where) {
  return {inner.row, [inner, where](const Node& node, T& to, Mistakes& mistakes) {
            inner.read(node, to, mistakes);
            to.*where = node.location;
          }};
}

/// The same with one struct of places in T for many values.
template <class T, class Locations>
config::Field<T> noted(config::Field<T> inner, Locations T::*locations, Location Locations::*where) {
  return {inner.row, [inner, locations, where](const Node& node, T& to, Mistakes& mistakes) {
            inner.read(node, to, mistakes);
            to.*locations.*where = node.location;
          }};
}

const Fields<Board> kBoard{
    noted(point("size", &Board::size, kExtent, kRequired, "its edges along X and Y"), &Board::locations,
          &BoardLocations::size),
    noted(number("thickness", &Board::thickness, D::Length, {0.01, 500}, kRequired,
                 "its top face stands this far above the frame's origin"),
          &Board::locations, &BoardLocations::thickness),
    noted(name_of("frame", &Board::frame, kRequired, "a frame of the machine"), &Board::frame_location),
    noted(point("at", &Board::at, kOnBoard, kOptional, "nominal place of its origin in that frame"), &Board::locations,
          &BoardLocations::at),
    noted(number("clamp_margin", &Board::clamp_margin, D::Length, {0, 100}, kOptional,
                 "kept free at the edges for the fixture: what looks, touches or dispenses there is a mistake"),
          &Board::locations, &BoardLocations::clamp_margin),
};

const Fields<Part> kPart{
    point("at", &Part::at, kOnBoard, kRequired, "its centre"),
    point("size", &Part::size, kExtent, kRequired, "its edges; the last is its height over the board"),
    number("rotation", &Part::rotation, D::Angle, kHalfTurn, kOptional, "counter-clockwise"),
};
const Fields<Part> kFixture{
    point("at", &Part::at, kOnBoard, kRequired, "its centre, with the board in its nominal placement"),
    point("size", &Part::size, kExtent, kRequired, "its edges; the last is its height"),
    number("rotation", &Part::rotation, D::Angle, kHalfTurn, kOptional, "counter-clockwise"),
    number("z", &Part::underside, D::Length, {0, 2000}, kOptional,
           "of its underside over the frame's origin: more than 0 and it hangs there, as the deck of a bridge"),
};

const Fields<MarkDef> kMark{
    point("at", &MarkDef::at, kOnBoard, kRequired, "its centre"),
    number("diameter", &MarkDef::diameter, D::Length, {0.1, 50}, kRequired, "of the disc"),
    flag("bright", &MarkDef::bright, kOptional, "brighter than the board"),
};
const Fields<MarkRules> kMarkRules{
    number("max_residual", &MarkRules::max_residual_mm, D::Length, {0.001, 5}, kOptional, "marks may disagree by this"),
    noted(number("max_shift", &MarkRules::max_shift_mm, D::Length, {0.01, 50}, kOptional,
                 "the board may lie this far off"),
          &MarkRules::locations, &MarkRulesLocations::max_shift),
    noted(number("max_rotation", &MarkRules::max_rotation_rad, D::Angle, {units::rad(0.1), units::rad(45)}, kOptional,
                 "the board may be turned by this"),
          &MarkRules::locations, &MarkRulesLocations::max_rotation),
    integer("attempts", &MarkRules::attempts, {1, 10}, kOptional, "pictures of a mark before it counts as missing"),
    config::choice("symmetric", &MarkRules::symmetric_allowed,
                   config::Choices<bool>{{"refused", false}, {"allowed", true}}, kOptional,
                   "`allowed`: the marks need not tell a board that lies turned in its seat, "
                   "or turned over, from one that lies right"),
};

const Fields<TouchPoint> kTouch{
    point("at", &TouchPoint::at, kOnBoard, kRequired, "where the probe touches the board"),
};
const Fields<TouchRules> kTouchRules{
    number("max_residual", &TouchRules::max_residual_mm, D::Length, {0.001, 5}, kOptional,
           "more than three touches may disagree by this"),
    noted(number("window", &TouchRules::window_mm, D::Length, {0.01, 50}, kOptional,
                 "the surface is within +- this of nominal"),
          &TouchRules::window_location),
    number("max_tilt", &TouchRules::max_tilt_rad, D::Angle, {units::rad(0.01), units::rad(5)}, kOptional,
           "the board is tilted by at most this: what fewer than three touches leave open, and what they may measure; "
           "left out, 0.15 deg of the one and 2 mm over 100 mm of the other"),
};

const Fields<Material> kMaterial{
    noted(number("speed", &Material::speed, D::Speed, {0.1, 1000}, kRequired, "path speed of a bead"),
          &Material::locations, &MaterialLocations::speed),
    number("gap", &Material::gap, D::Length, {0.01, 20}, kRequired, "between needle and surface"),
    noted(number("valve_open_lead", &Material::valve_open_lead, D::Time, {0, 0.5}, kRequired,
                 "the valve is opened this long before the needle is there"),
          &Material::locations, &MaterialLocations::valve_open_lead),
    noted(number("valve_close_lead", &Material::valve_close_lead, D::Time, {0, 0.5}, kRequired,
                 "the valve is closed this long before the end"),
          &Material::locations, &MaterialLocations::valve_close_lead),
    noted(number("dot_time", &Material::dot_time, D::Time, {0.001, 10}, kRequired,
                 "the valve is open this long on a dot: a cycle of the machine or more"),
          &Material::locations, &MaterialLocations::dot_time),
    number("settle_time", &Material::settle_time, D::Time, {0, 10}, kOptional, "standstill before a dot"),
    noted(number("retract", &Material::retract, D::Length, {0, 100}, kRequired,
                 "the needle lifts by this after a feature"),
          &Material::locations, &MaterialLocations::retract),
    number("tolerance", &Material::tolerance_mm, D::Length, {0.001, 10}, kOptional,
           "a deposit may lie beside its place by this, and end so far from its end; corners may be rounded besides"),
    number("gap_tolerance", &Material::gap_tolerance_mm, D::Length, {0.001, 10}, kOptional,
           "the gap may differ by this"),
    number("speed_tolerance", &Material::speed_tolerance, D::Ratio, {0.01, 1}, kOptional,
           "the speed may differ by this where the bead is steady, and how long the valve is open on a dot"),
    flag("flow_follows_speed", &Material::flow_follows_speed, kOptional,
         "the dispenser doses by the path speed, so that an override changes nothing on the board"),
    noted(number("start_dwell", &Material::start_dwell_s, D::Time, {0, 10}, kOptional,
                 "at the start of a bead the valve opens, the needle stands this long, a cycle of the machine or more, "
                 "and then the bead begins; 0 s: not at all"),
          &Material::locations, &MaterialLocations::start_dwell),
    noted(number("min_speed", &Material::min_speed, D::Speed, {0, 1000}, kOptional,
                 "a bead may begin as slowly as this where a body is in the way of its run-up; 0: from rest"),
          &Material::locations, &MaterialLocations::min_speed),
    noted(number("early_off", &Material::early_off, D::Length, {0, 100}, kOptional,
                 "the valve shuts this long before the end of a bead"),
          &Material::locations, &MaterialLocations::early_off),
    number("back_track", &Material::back_track, D::Length, {0, 100}, kOptional,
           "then the needle goes back along the bead by this, the valve shut"),
    noted(number("tail_lift", &Material::tail_lift, D::Length, {0, 100}, kOptional,
                 "and rises by this while it goes back, or straight up without `back_track`"),
          &Material::locations, &MaterialLocations::tail_lift),
    number("override_max", &Material::override_max, D::Ratio, {1, 2}, kOptional,
           "the highest override in a job that dispenses nothing that allows less, on a machine that allows less; "
           "above 100 "
           "% beads, dots and travel are no faster, only lines from rest to rest that a set speed holds"),
    number("rejoin_within", &Material::rejoin_within_s, D::Time, {0, 86400}, kOptional,
           "a bead that a hold has cut is joined again within this since its valve shut; later it stays cut"),
};

const Fields<Purge> kPurge{
    noted(name_of("material", &Purge::material, kRequired, "one of `materials`"), &Purge::material_location),
    noted(name_of("frame", &Purge::frame, kOptional, "a frame of the machine; left out: the board"),
          &Purge::frame_location),
    noted(
        point("at", &Purge::at, kOnBoard, kRequired,
              "where; the third is the height of what is shot on over the board, in a frame that of the needle's tip"),
        &Purge::at_location),
    integer("shots", &Purge::shots, {1, 1000}, kRequired, "each as long as a dot"),
    number("after", &Purge::after_s, D::Time, {0, 86400}, kRequired,
           "only when the valve was shut for longer; 0 s: in every job"),
};

const auto kName = name_of("name", &FeatureRow::name, kRequired, "its own name; reports and messages use it");
const auto kOf = name_of("material", &FeatureRow::material, kRequired, "one of `materials`");
const auto kOn = name_of("on", &FeatureRow::on, kOptional, "a part: heights count from its top; left out: the board");
const auto kCorner = number("corner_tolerance", &FeatureRow::corner_tolerance, D::Length, {0, 5}, kOptional,
                            "corners may be rounded by this; 0: stop in each");
const auto kCurve = number("corner_tolerance", &FeatureRow::curve_tolerance, D::Length, {0.001, 5}, kOptional,
                           "the needle stays as near to the curve as this");
const auto kStart = number("start", &FeatureRow::start_angle, D::Angle, kTurn, kOptional,
                           "where it starts: angle from X about the centre, counter-clockwise");
const auto kClockwise = flag("clockwise", &FeatureRow::clockwise, kOptional, "its sense of rotation, seen from above");
const auto kRotation =
    number("rotation", &FeatureRow::rotation, D::Angle, kTurn, kOptional, "counter-clockwise about `at`");

config::Field<FeatureRow> skipped() {
  ValueShape index{ValueShape::Kind::Integer, {}, {0, 9999}, {}, {}, {}};
  ValueShape pair{ValueShape::Kind::Tuple, {}, config::kAny, {}, {}, {index, index}};
  ValueShape shape{ValueShape::Kind::List, {}, {0, 10000}, {}, {}, {pair}};
  return {{"skip", kOptional, "[row, column] of what is left out, from 0", shape},
          [index, shape](const Node& node, FeatureRow& to, Mistakes& mistakes) {
            if (!config::expect_list(node, shape.range, mistakes)) return;
            if (!node.items.empty() && node.items[0].kind == Node::Kind::Scalar)
              return mistakes.add(Fault::BadValue, "pairs of row and column belong here; write for example [[0, 1]]",
                                  node.location);
            for (const Node& item : node.items) {
              if (!config::expect_list(item, {2, 2}, mistakes)) continue;
              const auto row = config::read_integer(item.items[0], index, mistakes);
              const auto column = config::read_integer(item.items[1], index, mistakes);
              if (!row || !column) continue;
              const bool known = to.rows > 0 && to.columns > 0;
              if (known && (*row >= to.rows || *column >= to.columns))
                mistakes.add(Fault::OutOfRange, "no such row or column in the array; both count from 0", item.location);
              to.skip.emplace_back(static_cast<int>(*row), static_cast<int>(*column));
            }
          }};
}

/// A point on the board, and the height of what lies there over its top face.
config::Field<FeatureRow> on_board(const char* key, At<Vec3> FeatureRow::*member, Need need, const char* doc) {
  return spot(key, member, kOnBoard, kHeight, need, doc);
}
config::Field<FeatureRow> length(const char* key, At<double> FeatureRow::*member, Range range, Need need,
                                 const char* doc) {
  return number(key, member, D::Length, range, need, doc);
}

auto tag(FeatureKind kind) {
  return [kind](FeatureRow& row) { row.kind = kind; };
}

std::vector<config::Variant<FeatureRow>> points_and_lines() {
  return {
      {"dot",
       "one shot",
       tag(FeatureKind::Dot),
       {kName, kOf, kOn, on_board("at", &FeatureRow::at, kRequired, "where")}},
      {"array",
       "dots in rows and columns",
       tag(FeatureKind::Array),
       {kName, kOf, kOn, on_board("at", &FeatureRow::at, kRequired, "the dot of row 0, column 0"),
        integer("rows", &FeatureRow::rows, {1, 10000}, kRequired, "along Y"),
        integer("columns", &FeatureRow::columns, {1, 10000}, kRequired, "along X"),
        point("pitch", &FeatureRow::pitch, {-1000, 1000}, kRequired, "from column to column, from row to row"),
        kRotation, skipped()}},
      {"line",
       "a straight bead",
       tag(FeatureKind::Line),
       {kName, kOf, kOn, on_board("from", &FeatureRow::at, kRequired, "its start"),
        on_board("to", &FeatureRow::to, kRequired, "its end")}},
      {"polyline",
       "a bead along points",
       tag(FeatureKind::Polyline),
       {kName, kOf, kOn,
        spots("points", &FeatureRow::points, {2, 10000}, kOnBoard, kHeight, kOptional,
              "in their order; or `points_file`"),
        config::text("points_file", &FeatureRow::points_file, kOptional,
                     "CSV file in the recipe's folder: x_mm,y_mm or x_mm,y_mm,z_mm, then a point a line"),
        kCorner, flag("closed", &FeatureRow::closed, kOptional, "goes back to its first point")}},
      {"rectangle",
       "a closed bead",
       tag(FeatureKind::Rectangle),
       {kName, kOf, kOn, on_board("at", &FeatureRow::at, kRequired, "its corner, where the bead starts and ends"),
        point("size", &FeatureRow::size, kExtent, kRequired, "its edges along X and Y"), kRotation, kCorner}},
  };
}

std::vector<config::Variant<FeatureRow>> curves_and_areas() {
  return {
      {"arc",
       "a bead along an arc: through three points, or about a centre",
       tag(FeatureKind::Arc),
       {kName, kOf, kOn, on_board("from", &FeatureRow::at, kRequired, "its start"),
        on_board("through", &FeatureRow::through, kOptional, "a point on it, with `to`"),
        on_board("to", &FeatureRow::to, kOptional, "its end"),
        on_board("centre", &FeatureRow::centre, kOptional, "its centre, with `angle`; level with `from`"),
        number("angle", &FeatureRow::angle, D::Angle, kTurn, kOptional, "counter-clockwise; below 0 clockwise"),
        kCurve}},
      {"circle",
       "a closed bead",
       tag(FeatureKind::Circle),
       {kName, kOf, kOn, on_board("centre", &FeatureRow::centre, kRequired, "its centre"),
        length("radius", &FeatureRow::from_radius, kRadius, kRequired, "its radius"), kStart, kClockwise, kCurve}},
      {"spiral",
       "a bead that winds outwards or inwards",
       tag(FeatureKind::Spiral),
       {kName, kOf, kOn, on_board("centre", &FeatureRow::centre, kRequired, "its centre"),
        length("from_radius", &FeatureRow::from_radius, {0, 1000}, kRequired, "where it starts"),
        length("to_radius", &FeatureRow::to_radius, {0, 1000}, kRequired, "where it ends"),
        length("spacing", &FeatureRow::spacing, kSpacing, kRequired, "from one turn to the next"), kStart, kClockwise,
        kCurve}},
      {"fill",
       "beads that cover a rectangle or a polygon with parallel lines",
       tag(FeatureKind::Fill),
       {kName, kOf, kOn, on_board("at", &FeatureRow::at, kOptional, "corner of a rectangle, with `size`"),
        point("size", &FeatureRow::size, kExtent, kOptional, "its edges along X and Y"), kRotation,
        spots("points", &FeatureRow::points, {3, kMostCorners}, kOnBoard, kHeight, kOptional,
              "or the corners of a polygon, all at one height"),
        length("spacing", &FeatureRow::spacing, kSpacing, kRequired, "from one line to the next"),
        number("angle", &FeatureRow::line_angle, D::Angle, kTurn, kOptional, "of the lines, from X, counter-clockwise"),
        flag("serpentine", &FeatureRow::serpentine, kOptional, "to and fro in one bead; false: each line is a bead"),
        kCorner}},
  };
}

std::vector<config::Variant<FeatureRow>> feature_kinds() {
  auto all = points_and_lines();
  for (auto& kind : curves_and_areas()) all.push_back(std::move(kind));
  for (auto& kind : all) {
    kind.fields.push_back(flag("off_board", &FeatureRow::off_board, kOptional, "it may leave the board"));
    kind.fields.push_back(config::names("after", &FeatureRow::after, {1, 1000}, kOptional,
                                        "a feature, or a list of them, that is dispensed before this one"));
  }
  for (auto& kind : all)
    for (config::Field<FeatureRow>& field : kind.fields)
      field.read = [key = field.row.key, read = field.read](const Node& node, FeatureRow& to, Mistakes& mistakes) {
        to.keys.push_back(key);
        read(node, to, mistakes);
      };
  return all;
}

/// A field of Recipe as a field of the file.
template <class U>
config::Field<RecipeFile> of_recipe(config::Field<U> inner) {
  return {inner.row,
          [inner](const Node& node, RecipeFile& to, Mistakes& mistakes) { inner.read(node, to.recipe, mistakes); }};
}

/// Fixtures are parts that stay where they are.
config::Field<RecipeFile> fixtures() {
  auto inner = named("fixtures", &Recipe::parts, kFixture, {0, kMostParts}, kOptional,
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
      of_recipe(config::choice("placement", &Recipe::placement,
                               config::Choices<Placement>{{"marks", Placement::Marks}, {"fixture", Placement::Fixture}},
                               kOptional,
                               "what says where the board lies; `fixture`: it holds it at its nominal placement")),
      of_recipe(config::choice("order", &Recipe::order,
                               config::Choices<Order>{{"file", Order::File}, {"shortest", Order::Shortest}}, kOptional,
                               "in which features are dispensed: that of the file, or one with little travel")),
      of_recipe(object("board", &Recipe::board, kBoard, kRequired, "what lies on the machine")),
      of_recipe(named("parts", &Recipe::parts, kPart, {0, kMostParts}, kOptional, "what stands on the board")),
      fixtures(),
      of_recipe(named("keep_out", &Recipe::keep_out, kFixture, {0, kMostParts}, kOptional,
                      "zones that nothing of the head enters, beside or above the board; they stay where they are, and "
                      "are no matter")),
      of_recipe(named("marks", &Recipe::marks, kMark, {2, 100}, kOptional,
                      "fiducials; at least two, three to trust them; without them the recipe says `placement: "
                      "fixture`, or its jobs "
                      "end with defects")),
      of_recipe(object("mark_rules", &Recipe::mark_rules, kMarkRules, kOptional, "when marks are believed")),
      of_recipe(
          named("touches", &Recipe::touches, kTouch, {1, 100}, kOptional,
                "where the height is probed; three give a plane; without them the height is taken to be nominal")),
      of_recipe(object("touch_rules", &Recipe::touch_rules, kTouchRules, kOptional, "when touches are believed")),
      of_recipe(named("materials", &Recipe::materials, kMaterial, {1, 100}, kRequired, "what is dispensed, and how")),
      of_recipe(object("purge", &Recipe::purge, kPurge, kOptional, "shots beside the work before the first deposit")),
      list_of_variants("features", &RecipeFile::features, feature_kinds(), {1, 100000}, kRequired,
                       "what is dispensed where; `order` says in which order"),
  };
  return kFields;
}

}  // namespace written

const std::vector<config::FieldShape>& recipe_format() {
  static const std::vector<config::FieldShape> kFormat = config::object_shape(written::recipe_fields()).fields;
  return kFormat;
}

}  // namespace gantry::recipes
