#include "motion/plan/scene_file.hpp"

#include <array>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <set>

#include "config/fields.hpp"

namespace gantry::motion {
namespace {

using namespace config;

constexpr YamlBudget kBudget{4u << 20, 400000, 16};
constexpr double kFarthest_mm = 1e5, kThinnest_mm = 1e-6;

enum class Type { Box, Cylinder, Capsule, Sphere };

struct ShapeRow {
  Place place;
  At<std::string> name;
  At<Type> type;
  At<Vec3> centre;
  At<Vec3> size;
  At<double> radius, length;
  double yaw_deg = 0;
};
struct SpaceRow {
  Place place;
  At<Vec3> min, max;
};
struct SceneRow {
  SpaceRow workspace;
  double clearance_mm = 0;
  std::vector<ShapeRow> head, obstacles, keep_out;
};

/// [x, y, z] without units.
template <class T>
Field<T> numbers(std::string key, At<Vec3> T::*member, Range range, Need need, std::string doc) {
  ValueShape shape = detail::tuple_shape(3, {Dimension::None}, range);
  return {{std::move(key), need, std::move(doc), shape}, [member, shape](const Node& node, T& to, Mistakes& mistakes) {
            std::vector<Quantity> v;
            if (read_tuple(node, shape, v, mistakes))
              detail::put(to.*member, Vec3{v[0].value, v[1].value, v[2].value}, node);
          }};
}

const Choices<Type> kTypes{
    {"box", Type::Box}, {"cylinder", Type::Cylinder}, {"capsule", Type::Capsule}, {"sphere", Type::Sphere}};
constexpr Range kPlace{-kFarthest_mm, kFarthest_mm}, kSize{kThinnest_mm, kFarthest_mm};

const Fields<ShapeRow> kShape{
    text("name", &ShapeRow::name, kRequired, "what messages call it"),
    choice("type", &ShapeRow::type, kTypes, kRequired, "its form"),
    numbers("center", &ShapeRow::centre, kPlace, kRequired, "its middle in mm; of the head: from the tip"),
    numbers("size", &ShapeRow::size, kSize, kOptional, "of a box: full edges x, y, z in mm"),
    number("radius", &ShapeRow::radius, Dimension::None, kSize, kOptional, "of all but a box, in mm"),
    number("length", &ShapeRow::length, Dimension::None, {0, kFarthest_mm}, kOptional,
           "of a cylinder, or between the centres of a capsule's spheres, along Z, in mm"),
    number("yaw_deg", &ShapeRow::yaw_deg, Dimension::None, {-3600, 3600}, kOptional, "turn about Z at its middle"),
};
const Fields<SpaceRow> kSpace{
    numbers("min", &SpaceRow::min, kPlace, kRequired, "lowest x, y, z of the tip in mm"),
    numbers("max", &SpaceRow::max, kPlace, kRequired, "highest x, y, z of the tip in mm"),
};
const Fields<SceneRow> kScene{
    object("workspace_tip", &SceneRow::workspace, kSpace, kRequired, "where the tip may be"),
    number("required_clearance_mm", &SceneRow::clearance_mm, Dimension::None, {0, 1000}, kRequired,
           "a distance of at most this much is a collision"),
    list("head", &SceneRow::head, kShape, {1, 200}, kRequired, "bodies that move with the tip"),
    list("obstacles", &SceneRow::obstacles, kShape, {0, 20000}, kRequired, "bodies that stand; may be empty: []"),
    list("keep_out", &SceneRow::keep_out, kShape, {0, 20000}, kOptional, "zones that the head must not enter"),
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
  const auto check = [&](const char* key, bool wanted, Place given) {
    if (wanted && given.line == 0)
      mistakes.add(Fault::MissingKey, fmt::format("a {} needs '{}'", needs.name, key), row.place);
    if (!wanted && given.line != 0)
      mistakes.add(Fault::UnknownKey, fmt::format("a {} has no '{}'; remove it or correct the type", needs.name, key),
                   given);
  };
  check("size", needs.size, row.size.place);
  check("radius", needs.radius, row.radius.place);
  check("length", needs.length, row.length.place);
}

void take(const std::vector<ShapeRow>& rows, std::set<std::string>& names, std::vector<Body>& to, Mistakes& mistakes) {
  for (const ShapeRow& row : rows) {
    check_measures(row, mistakes);
    if (row.name.given() && !names.insert(row.name.value).second)
      mistakes.add(Fault::DuplicateKey,
                   fmt::format("the name '{}' stands twice; give each body its own", shortened(row.name.value, 60)),
                   row.name.place);
    const double across = 2 * row.radius.value;
    Body body{row.name.value, {}, row.centre.value, row.yaw_deg * std::numbers::pi / 180, false};
    switch (row.type.value) {
      case Type::Box: body.shape = {Shape::Kind::Box, row.size.value}; break;
      case Type::Cylinder: body.shape = {Shape::Kind::Cylinder, {across, across, row.length.value}}; break;
      case Type::Capsule: body.shape = {Shape::Kind::Capsule, {across, across, row.length.value + across}}; break;
      case Type::Sphere: body.shape = {Shape::Kind::Capsule, {across, across, across}}; break;
    }
    to.push_back(body);
  }
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
                   space.min.place);
    machine.axes.push_back(axis);
  }
  machine.x = AxisId{0}, machine.y = AxisId{1}, machine.z = AxisId{2};
}

/// JSON may be indented with tabs, YAML may not; within its strings no tab may stand, so none is lost.
std::string without_tabs_of_json(std::string_view text) {
  std::string out(text);
  const auto first = out.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && (out[first] == '{' || out[first] == '['))
    for (char& c : out)
      if (c == '\t') c = ' ';
  return out;
}

}  // namespace

Checked<Machine> parse_scene(std::string_view text, const std::string& name) {
  Mistakes mistakes(name);
  const auto root = read_yaml(without_tabs_of_json(text), mistakes, kBudget);
  if (!root) return tl::unexpected(mistakes.errors());
  SceneRow row;
  read_object(*root, kScene, row, {1, 1}, mistakes);
  Machine machine;
  machine.name = name, machine.file = name;
  machine.clearance_mm = row.clearance_mm;
  take_space(row.workspace, machine, mistakes);
  std::set<std::string> of_head, standing;
  take(row.head, of_head, machine.head, mistakes);
  take(row.obstacles, standing, machine.scene, mistakes);
  take(row.keep_out, standing, machine.scene, mistakes);
  if (!mistakes.none()) return tl::unexpected(mistakes.errors());
  return machine;
}

Checked<Machine> load_scene(const std::string& path) {
  const auto text = read_text_file(path, kBudget.bytes);
  if (!text) return tl::unexpected(std::vector{text.error()});
  return parse_scene(*text, path);
}

}  // namespace gantry::motion
