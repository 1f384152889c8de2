#include "motion/plan/scene_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>

#include "config/fields.hpp"
#include "core/units.hpp"

namespace gantry::motion {
namespace {

using namespace config;

constexpr YamlBudget kBudget{4u << 20, 400000, 16};
constexpr double kFarthest_mm = 1e5, kThinnest_mm = 1e-6, kFarthestTurn_deg = 3600;

enum class Type { Box, Cylinder, Capsule, Sphere };

struct ShapeRow {
  Location location;
  At<std::string> name;
  At<Type> type;
  At<Vec3> centre;
  At<Vec3> size;
  At<double> radius, length;
  double yaw_deg = 0;
  bool on_turn = false;
};
struct SpaceRow {
  Location location;
  At<Vec3> min, max;
};
struct SceneRow {
  SpaceRow workspace;
  double clearance_mm = 0;
  At<std::pair<double, double>> turn_deg;
  std::vector<ShapeRow> head, obstacles, keep_out;
};

/// [x, y, z] without units.
template <class T>
Field<T> numbers(std::string key, At<Vec3> T::*member, Range range, Need need, std::string doc) {
  ValueShape shape = detail::tuple_shape(3, {Dimension::None}, range);
  return {{std::move(key), need, std::move(doc), shape}, [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            std::vector<Quantity> v;
            (to.*member).location = node.location;
            if (read_tuple(node, shape, v, mistakes))
              detail::put(to.*member, Vec3{v[0].value, v[1].value, v[2].value}, node);
          }};
}

/// [min, max] in degrees.
Field<SceneRow> turn_range() {
  ValueShape shape = detail::tuple_shape(2, {Dimension::None}, {-kFarthestTurn_deg, kFarthestTurn_deg});
  return {{"turn_deg", kOptional, "range of C in degrees, where a body of the head turns; else -180 to 180", shape},
          [shape](const Node& node, SceneRow& to, Mistakes& mistakes) {
            std::vector<Quantity> v;
            to.turn_deg.location = node.location;
            if (read_tuple(node, shape, v, mistakes)) detail::put(to.turn_deg, std::pair(v[0].value, v[1].value), node);
          }};
}

/// Its location is known even where the number is none, so that a wrong one is not also told as missing.
template <class T>
Field<T> measure(std::string key, At<double> T::*member, Range range, std::string doc) {
  ValueShape shape{ValueShape::Kind::Number, {Dimension::None}, range, {}, {}, {}};
  return {{std::move(key), kOptional, std::move(doc), shape},
          [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            (to.*member).location = node.location;
            if (const auto v = read_quantity(node, shape, mistakes)) detail::put(to.*member, v->value, node);
          }};
}

const Choices<Type> kTypes{
    {"box", Type::Box}, {"cylinder", Type::Cylinder}, {"capsule", Type::Capsule}, {"sphere", Type::Sphere}};
constexpr Range kPosition{-kFarthest_mm, kFarthest_mm}, kSize{kThinnest_mm, kFarthest_mm};

Fields<ShapeRow> shape_fields(bool head) {
  Fields<ShapeRow> fields{
      text("name", &ShapeRow::name, kRequired, "what messages call it"),
      choice("type", &ShapeRow::type, kTypes, kRequired, "its form"),
      numbers("center", &ShapeRow::centre, kPosition, kRequired, "its middle in mm; of the head: from the tip"),
      numbers("size", &ShapeRow::size, kSize, kOptional, "of a box: full edges x, y, z in mm"),
      measure("radius", &ShapeRow::radius, kSize, "of all but a box, in mm"),
      measure("length", &ShapeRow::length, {0, kFarthest_mm},
              "of a cylinder, or between the centres of a capsule's spheres, along Z, in mm"),
      number("yaw_deg", &ShapeRow::yaw_deg, Dimension::None, {-3600, 3600}, kOptional, "turn about Z at its middle"),
  };
  if (head)
    fields.push_back(
        flag("on_turn", &ShapeRow::on_turn, kOptional, "turns with C about the upright line through the tip"));
  return fields;
}
const Fields<ShapeRow> kHeadShape = shape_fields(true), kShape = shape_fields(false);
const Fields<SpaceRow> kSpace{
    numbers("min", &SpaceRow::min, kPosition, kRequired, "lowest x, y, z of the tip in mm"),
    numbers("max", &SpaceRow::max, kPosition, kRequired, "highest x, y, z of the tip in mm"),
};
const Fields<SceneRow> kScene{
    object("workspace_tip", &SceneRow::workspace, kSpace, kRequired, "where the tip may be"),
    number("required_clearance_mm", &SceneRow::clearance_mm, Dimension::None, {0, 1000}, kRequired,
           "a distance of at most this much is a collision"),
    list("head", &SceneRow::head, kHeadShape, {1, 200}, kRequired, "bodies that move with the tip"),
    list("obstacles", &SceneRow::obstacles, kShape, {0, 20000}, kRequired, "bodies that stand; may be empty: []"),
    list("keep_out", &SceneRow::keep_out, kShape, {0, 20000}, kOptional, "zones that the head must not enter"),
    turn_range(),
};

/// Which of size, radius and length a type has.
struct Needs {
  const char* name;
  bool size, radius, length;
};
constexpr std::array<Needs, 4> kNeeds{{{"box", true, false, false},
                                       {"cylinder", false, true, true},
                                       {"capsule", false, true, true},
                                       {"sphere", false, true, false}}};

void check_measures(const ShapeRow& row, Mistakes& mistakes) {
  if (!row.type.given()) return;
  const Needs& needs = kNeeds[static_cast<std::size_t>(row.type.value)];
  const auto check = [&](const char* key, bool wanted, Location given) {
    if (wanted && given.line == 0)
      mistakes.add(Fault::MissingKey, fmt::format("a {} needs '{}'", needs.name, key), row.location);
    if (!wanted && given.line != 0)
      mistakes.add(Fault::UnknownKey, fmt::format("a {} has no '{}'; remove it or correct the type", needs.name, key),
                   given);
  };
  check("size", needs.size, row.size.location);
  check("radius", needs.radius, row.radius.location);
  check("length", needs.length, row.length.location);
}

void take(const std::vector<ShapeRow>& rows, std::set<std::string>& names, std::vector<Body>& to, Mistakes& mistakes) {
  for (const ShapeRow& row : rows) {
    check_measures(row, mistakes);
    if (row.name.given() && !names.insert(row.name.value).second)
      mistakes.add(Fault::DuplicateKey,
                   fmt::format("the name '{}' stands twice; give each body its own", shortened(row.name.value, 60)),
                   row.name.location);
    const double across = 2 * row.radius.value;
    Body body{row.name.value, {}, row.centre.value, row.yaw_deg * std::numbers::pi / 180, false};
    switch (row.type.value) {
      case Type::Box: body.shape = {Shape::Kind::Box, row.size.value}; break;
      case Type::Cylinder: body.shape = {Shape::Kind::Cylinder, {across, across, row.length.value}}; break;
      case Type::Capsule: body.shape = {Shape::Kind::Capsule, {across, across, row.length.value + across}}; break;
      case Type::Sphere: body.shape = {Shape::Kind::Capsule, {across, across, across}}; break;
    }
    body.on_turn = row.on_turn;
    to.push_back(body);
  }
}

/// By where and what they are: answers do not depend on the order in which a document lists its bodies.
void sort_by_geometry(std::vector<Body>& bodies) {
  const auto key = [](const Body& b) {
    const Vec3 c = b.centre, s = b.shape.size;
    return std::tuple(c.x, c.y, c.z, s.x, s.y, s.z, b.shape.kind, b.rotation_rad, std::string_view(b.name));
  };
  std::sort(bodies.begin(), bodies.end(), [&](const Body& a, const Body& b) { return key(a) < key(b); });
}

void take_space(const SpaceRow& space, Machine& machine, Mistakes& mistakes) {
  const std::array<std::pair<const char*, double Vec3::*>, 3> kAxes{
      {{"X", &Vec3::x}, {"Y", &Vec3::y}, {"Z", &Vec3::z}}};
  for (std::size_t i = 0; i < 3; ++i) {
    Axis axis;
    axis.id = AxisId{static_cast<std::uint8_t>(i)};
    axis.name = kAxes[i].first;
    axis.p_min = space.min.value.*kAxes[i].second, axis.p_max = space.max.value.*kAxes[i].second;
    if (space.min.given() && space.max.given() && axis.p_min > axis.p_max)
      mistakes.add(Fault::OutOfRange,
                   fmt::format("'min' of {} is {:.9g}, more than 'max', which is {:.9g}; exchange them", axis.name,
                               axis.p_min, axis.p_max),
                   space.min.location);
    machine.axes.push_back(axis);
  }
  machine.x = AxisId{0}, machine.y = AxisId{1}, machine.z = AxisId{2};
}

/// C is there where a body turns with it.
void take_turn(const SceneRow& row, Machine& machine, Mistakes& mistakes) {
  const bool turns = std::ranges::any_of(row.head, &ShapeRow::on_turn);
  if (!turns) {
    if (row.turn_deg.given())
      mistakes.add(Fault::Inconsistent, "no body of the head turns; give one `on_turn: true`, or leave 'turn_deg' out",
                   row.turn_deg.location);
    return;
  }
  const auto [min_deg, max_deg] = row.turn_deg.given() ? row.turn_deg.value : std::pair(-180.0, 180.0);
  if (min_deg > max_deg)
    mistakes.add(
        Fault::OutOfRange,
        fmt::format("the first number, {:.9g}, is more than the second, {:.9g}; exchange them", min_deg, max_deg),
        row.turn_deg.location);
  Axis axis;
  axis.id = AxisId{static_cast<std::uint8_t>(machine.axes.size())};
  axis.name = "C", axis.rotary = true;
  axis.p_min = units::rad(min_deg), axis.p_max = units::rad(max_deg);
  machine.axes.push_back(axis);
  machine.c = axis.id;
}

/// The four hexadecimal digits of a JSON escape "\\uXXXX" at `at`; nothing where there is none.
std::optional<std::uint32_t> escaped_unit(std::string_view text, std::size_t at) {
  std::uint32_t unit = 0;
  if (at + 6 > text.size() || text.substr(at, 2) != "\\u") return std::nullopt;
  const char *const first = text.data() + at + 2, *const last = first + 4;
  const auto [end, error] = std::from_chars(first, last, unit, 16);
  if (error != std::errc{} || end != last) return std::nullopt;
  return unit;
}

/// JSON as YAML: it may be indented with tabs (within its strings no tab may stand, so none is lost), and it writes a
/// character beyond U+FFFF as two escapes (RFC 8259, 7), which YAML knows as one of eight digits.
std::string json_as_yaml(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos || (text[first] != '{' && text[first] != '[')) return std::string(text);
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\t') {
      out += ' ';
    } else if (text[i] != '\\' || i + 1 == text.size()) {
      out += text[i];
    } else {
      const auto high = escaped_unit(text, i), low = escaped_unit(text, i + 6);
      if (high && low && (*high & 0xfc00U) == 0xd800U && (*low & 0xfc00U) == 0xdc00U) {
        out += fmt::format("\\U{:08X}", 0x10000U + ((*high & 0x3ffU) << 10) + (*low & 0x3ffU));
        i += 11;
      } else {
        out.append(text, i, 2);
        ++i;
      }
    }
  }
  return out;
}

}  // namespace

Checked<Machine> parse_scene(std::string_view text, const std::string& name) {
  Mistakes mistakes(name);
  const auto root = read_yaml(json_as_yaml(text), mistakes, kBudget);
  if (!root || !is_of_format(*root, object_shape(kScene).fields, "a scene document", mistakes))
    return tl::unexpected(mistakes.errors());
  SceneRow row;
  read_object(*root, kScene, row, {1, 1}, mistakes);
  Machine machine;
  machine.name = name, machine.file = name;
  machine.clearance_mm = row.clearance_mm;
  take_space(row.workspace, machine, mistakes);
  take_turn(row, machine, mistakes);
  std::set<std::string> of_head, standing;
  take(row.head, of_head, machine.head, mistakes);
  take(row.obstacles, standing, machine.scene, mistakes);
  take(row.keep_out, standing, machine.scene, mistakes);
  sort_by_geometry(machine.scene);
  if (!mistakes.none()) return tl::unexpected(mistakes.errors());
  return machine;
}

Checked<Machine> load_scene(const std::string& path) {
  const auto text = read_text_file(path, kBudget.bytes);
  if (!text) return tl::unexpected(std::vector{text.error()});
  return parse_scene(*text, path);
}

}  // namespace gantry::motion
