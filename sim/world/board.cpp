#include "sim/world/board.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <variant>

#include "core/trimmed.hpp"
#include "core/units.hpp"
#include "sim/random.hpp"

namespace gantry::sim {

namespace {

struct PlacementKey {
  std::string_view key;
  units::Dimension dimension;
};
constexpr std::array kPlacementKeys{
    PlacementKey{"dx", units::Dimension::Length},    PlacementKey{"dy", units::Dimension::Length},
    PlacementKey{"rot", units::Dimension::Angle},    PlacementKey{"dz", units::Dimension::Length},
    PlacementKey{"tilt_x", units::Dimension::Angle}, PlacementKey{"tilt_y", units::Dimension::Angle}};
constexpr double kFarthest_mm = 2000, kFarthest_rad = units::rad(360);

}  // namespace

Result<PlacementText> parse_placement(std::string_view text) {
  std::array<std::optional<double>, kPlacementKeys.size()> values;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view raw = text.substr(begin, end - begin);
    const std::string_view item = trimmed(raw);
    const std::size_t column = begin + (item.empty() ? 0 : static_cast<std::size_t>(item.data() - raw.data())) + 1;
    const std::string where = fmt::format("--sim-board:1:{}", column);
    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos)
      return fail(Fault::BadValue,
                  fmt::format("'{}' is no placement; write for example \"dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg\"", item),
                  where);
    const std::string_view key = trimmed(item.substr(0, equals));
    const auto* known =
        std::find_if(kPlacementKeys.begin(), kPlacementKeys.end(), [&](const PlacementKey& k) { return k.key == key; });
    if (known == kPlacementKeys.end())
      return fail(Fault::UnknownKey,
                  fmt::format("unknown part '{}' of a placement; known are dx, dy, rot (and dz, tilt_x, tilt_y)", key),
                  where);
    auto& value = values[static_cast<std::size_t>(known - kPlacementKeys.begin())];
    if (value) return fail(Fault::DuplicateKey, fmt::format("'{}' stands twice; remove one of the two", key), where);
    if (item.find('=', equals + 1) != std::string_view::npos)
      return fail(Fault::BadValue, fmt::format("'{}' lacks a comma between its values", item), where);
    const auto parsed = units::parse(trimmed(item.substr(equals + 1)), known->dimension);
    if (!parsed) return fail(parsed.error().fault, fmt::format("{}: {}", key, parsed.error().message), where);
    const bool turns = known->dimension == units::Dimension::Angle;
    if (std::abs(*parsed) > (turns ? kFarthest_rad : kFarthest_mm))
      return fail(Fault::OutOfRange, fmt::format("{} is beyond {}", key, turns ? "360 deg" : "2000 mm"), where);
    value = *parsed;
    begin = end + 1;
  }
  PlacementText out;
  out.shift = {values[0].value_or(0), values[1].value_or(0)};
  out.rotation_rad = values[2].value_or(0);
  out.z0_mm = values[3];
  out.slope_x = values[4];
  out.slope_y = values[5];
  return out;
}

BoardPlacement draw_placement(const config::SimConfig& truth, std::uint64_t seed, std::uint64_t board,
                              const std::optional<PlacementText>& text, bool in_fixture) {
  // One draw for each value, whether it is used or not, so that a text changes only what it names.
  Random random(mix(seed, mix(0xB0A2D, board)));
  BoardPlacement p;
  p.shift.x = random.symmetric(truth.placement_spread_mm);
  p.shift.y = random.symmetric(truth.placement_spread_mm);
  p.rotation_rad = random.symmetric(truth.placement_spread_rad);
  p.z0_mm = random.symmetric(truth.height_spread_mm);
  p.slope.x = random.symmetric(truth.tilt_spread_rad);
  p.slope.y = random.symmetric(truth.tilt_spread_rad);
  if (in_fixture) p.shift = {}, p.rotation_rad = 0;
  if (text) {
    p.shift = text->shift;
    p.rotation_rad = text->rotation_rad;
    p.z0_mm = text->z0_mm.value_or(p.z0_mm);
    p.slope.x = text->slope_x.value_or(p.slope.x);
    p.slope.y = text->slope_y.value_or(p.slope.y);
  }
  return p;
}

std::string to_text(const BoardPlacement& p) {
  return fmt::format("dx={:.6g} mm, dy={:.6g} mm, rot={:.6g} deg, dz={:.6g} mm, tilt_x={:.6g} deg, tilt_y={:.6g} deg",
                     p.shift.x, p.shift.y, units::deg(p.rotation_rad), p.z0_mm, units::deg(p.slope.x),
                     units::deg(p.slope.y));
}

std::string to_text(const PlacementText& p) {
  std::string text =
      fmt::format("dx={:.9g} mm, dy={:.9g} mm, rot={:.9g} deg", p.shift.x, p.shift.y, units::deg(p.rotation_rad));
  if (p.z0_mm) text += fmt::format(", dz={:.9g} mm", *p.z0_mm);
  if (p.slope_x) text += fmt::format(", tilt_x={:.9g} deg", units::deg(*p.slope_x));
  if (p.slope_y) text += fmt::format(", tilt_y={:.9g} deg", units::deg(*p.slope_y));
  return text;
}

BoardPlan board_plan(const recipes::Recipe& recipe) {
  BoardPlan plan{.name = recipe.name,
                 .board = recipe.board,
                 .parts = recipe.parts,
                 .marks = recipe.marks,
                 .features = {},
                 .touches = recipe.touches.size(),
                 .purge = recipe.purge,
                 .in_fixture = recipe.placement == recipes::Placement::Fixture};
  const auto material_of = [&](const std::string& name) {
    const recipes::Material* m = recipes::find_material(recipe, name);
    return m != nullptr ? *m : recipes::Material{};
  };
  // In the order in which they are dispensed: of two that lie on each other the first shot is that of the earlier one.
  for (const std::size_t index : recipes::sequence_of(recipe)) {
    const recipes::Feature& feature = recipe.features[index];
    if (const auto* dot = std::get_if<recipes::Dot>(&feature)) {
      const Vec3 at{dot->at.x, dot->at.y, dot->height_mm};
      plan.features.push_back({.id = dot->id, .points = {at}, .gap_mm = material_of(dot->material).gap});
    } else if (const auto* bead = std::get_if<recipes::Bead>(&feature)) {
      const recipes::Material m = material_of(bead->material);
      plan.features.push_back({.id = bead->id,
                               .bead = true,
                               .points = recipes::without_end(*bead, m.early_off),
                               .gap_mm = m.gap,
                               .speed_mm_s = m.speed,
                               .speed_tolerance = m.speed_tolerance});
    }
  }
  return plan;
}

Starts starts_of(const BoardPlan& plan) {
  constexpr double kNowhere_mm = 1e9;  // a feature without points
  std::vector<Vec2> points;
  for (const BoardPlan::Feature& f : plan.features)
    points.push_back(f.points.empty() ? Vec2{kNowhere_mm, kNowhere_mm} : flat(f.points.front()));
  return Starts(points);
}

BoardTruth::BoardTruth(BoardPlan cad, Vec3 frame_origin, const BoardPlacement& placement)
    : plan(std::move(cad)),
      origin_(frame_origin),
      nominal_(frame_origin + Vec3{plan.board.at.x, plan.board.at.y, plan.board.thickness}),
      placement_(placement),
      starts_(starts_of(plan)),
      cos_(std::cos(placement.rotation_rad)),
      sin_(std::sin(placement.rotation_rad)) {}

Vec3 BoardTruth::nominal_to_machine(Vec2 p, double height) const { return nominal_ + Vec3{p.x, p.y, height}; }

Vec3 BoardTruth::to_machine(Vec2 p, double height) const {
  const Vec2 turned{cos_ * p.x - sin_ * p.y, sin_ * p.x + cos_ * p.y};
  return nominal_ + Vec3{turned.x + placement_.shift.x, turned.y + placement_.shift.y,
                         height + placement_.z0_mm + dot(placement_.slope, p)};
}

Vec3 BoardTruth::to_board(Vec3 m) const {
  const double dx = m.x - nominal_.x - placement_.shift.x, dy = m.y - nominal_.y - placement_.shift.y;
  const Vec2 p{cos_ * dx + sin_ * dy, cos_ * dy - sin_ * dx};
  return {p.x, p.y, m.z - nominal_.z - placement_.z0_mm - dot(placement_.slope, p)};
}

}  // namespace gantry::sim
