#include "app/record/drawing.hpp"

#include <string_view>
#include <variant>

namespace gantry::record {
namespace {

std::string_view tool_of(const recipes::Block& block) {
  if (std::holds_alternative<recipes::LookAtMark>(block.what)) return "camera";
  if (std::holds_alternative<recipes::Touch>(block.what)) return "probe";
  return "needle";
}

template <class Feature>
Allowed allowed_of(const recipes::Recipe& recipe, const Feature& feature) {
  Allowed out;
  if (const recipes::Material* m = recipes::find_material(recipe, feature.material))
    out = {m->tolerance_mm, m->gap_tolerance_mm};
  if constexpr (std::is_same_v<Feature, recipes::Bead>) out.beside_mm += feature.corner_tolerance;
  return out;
}

std::vector<DrawnBody> bodies_of(const recipes::Recipe& recipe, const config::Machine& machine,
                                 const recipes::WorkOffset& offset, const recipes::Surface& surface) {
  using Role = DrawnBody::Role;
  std::vector<DrawnBody> out;
  for (const config::Body& body : machine.scene) out.push_back({Role::Machine, body});
  const auto placed = recipes::bodies(recipe, machine, offset, surface);  // the board, then the parts in their order
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const Role role = i == 0 ? Role::Board : recipe.parts[i - 1].fixture ? Role::Fixture : Role::Part;
    if (role != Role::Board || (recipe.board.size.x > 0 && recipe.board.size.y > 0)) out.push_back({role, placed[i]});
  }
  for (const config::Body& body : machine.head) out.push_back({Role::Head, body});
  for (const config::Body& zone : machine.keep_out) out.push_back({Role::Zone, zone});
  for (const config::Body& zone : recipes::zones(recipe, machine)) out.push_back({Role::Zone, zone});
  return out;
}

/// What has a place on the board, wherever that lies.
void place(Drawing& d, const recipes::Recipe& recipe, const config::Machine& machine, const recipes::WorkOffset& offset,
           const recipes::Surface& surface) {
  const auto at = [&](Vec2 p, double height_mm) {
    return recipes::to_machine(recipe, machine, offset, surface, p, height_mm);
  };
  d.bodies = bodies_of(recipe, machine, offset, surface);
  d.spots.clear(), d.asked.clear();
  for (const recipes::MarkDef& mark : recipe.marks) d.spots.push_back({mark.name, at(mark.at, 0), false});
  for (const recipes::TouchPoint& touch : recipe.touches) d.spots.push_back({touch.name, at(touch.at, 0), true});
  for (const recipes::Feature& feature : recipe.features) {
    std::vector<Vec3>& points = d.asked.emplace_back();
    if (const auto* dot = std::get_if<recipes::Dot>(&feature))
      points.push_back(at(dot->at, dot->height_mm));
    else
      for (const Vec3 p : std::get<recipes::Bead>(feature).points) points.push_back(at(flat(p), p.z));
  }
}

}  // namespace

Drawing drawing_of(const recipes::Recipe& recipe, const config::Machine& machine, const recipes::Job& job) {
  Drawing d;
  d.board_size = recipe.board.size;
  if (const auto* frame = config::find_frame(machine, recipe.board.frame))
    d.board_origin = frame->origin + Vec3{recipe.board.at.x, recipe.board.at.y, recipe.board.thickness};
  for (const auto& p : recipe.parts) d.parts.push_back({p.name, p.at, p.size, p.rotation, p.fixture});
  for (const auto& feature : recipe.features)
    std::visit([&](const auto& f) { d.allowed[f.id] = allowed_of(recipe, f); }, feature);
  for (const auto& tool : machine.tools)
    if (tool.lift_mm != 0) d.lifted_tip = tool.tip - Vec3{0, 0, tool.lift_mm}, d.lifted_at_mm = tool.lift_mm;
  for (const auto& block : job.blocks) {
    const auto* tool = config::find_tool(machine, tool_of(block));
    if (d.tip_of_block.size() <= block.number) d.tip_of_block.resize(block.number + 1);
    if (tool != nullptr) d.tip_of_block[block.number] = tool->tip - Vec3{0, 0, tool->lift_mm};
  }
  d.xyz = {machine.x.value, machine.y.value, machine.z.value};
  if (machine.u) d.lift = machine.u->value;
  if (machine.c) d.turn = machine.c->value, d.turn_axis = config::turn_axis(machine);
  for (const auto& [axis, position] : machine.park) {
    if (axis == machine.x) d.park.x = position;
    if (axis == machine.y) d.park.y = position;
    if (axis == machine.z) d.park.z = position;
    if (machine.c && axis == *machine.c) d.park_turn_rad = position;
  }
  place(d, recipe, machine, {}, {});
  return d;
}

Drawing placed_drawing(const JobResult& result, const recipes::Recipe& recipe, const config::Machine& machine) {
  Drawing d = result.drawing;
  place(d, recipe, machine, result.offset, result.surface);
  return d;
}

}  // namespace gantry::record
