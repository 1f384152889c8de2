#include "recipes/job.hpp"

namespace gantry::recipes {
namespace {

Vec3 frame_origin(const Recipe& recipe, const config::Machine& machine) {
  const config::WorkFrame* frame = config::find_frame(machine, recipe.board.frame);
  return frame ? frame->origin : Vec3{};
}

Vec2 on_frame(const Recipe& recipe, const WorkOffset& offset, Vec2 at) {
  return rotated(at, offset.rotation) + offset.shift + recipe.board.at;
}

config::Body upright_box(std::string name, Vec3 below, Vec3 size, double rotation) {
  return {std::move(name), {config::Shape::Kind::Box, size}, below + Vec3{0, 0, size.z / 2}, rotation};
}

/// Of what stays where it is, however the board lies: the middle of its underside.
Vec3 below_fixture(const Recipe& recipe, const config::Machine& machine, const Part& part) {
  const Vec2 at = part.at + recipe.board.at;
  return frame_origin(recipe, machine) + Vec3{at.x, at.y, part.underside};
}

}  // namespace

AxisVec tool_at(const config::Machine& machine, const config::Tool& tool, Vec3 tip, double needle_turn_rad) {
  AxisVec q{};
  for (const auto& [axis, position] : machine.park) q[axis.value] = position;
  q[machine.x.value] = tip.x - tool.tip.x;
  q[machine.y.value] = tip.y - tool.tip.y;
  q[machine.z.value] = tip.z - tool.tip.z + tool.lift_mm;
  if (machine.c) q[machine.c->value] = needle_turn_rad;
  if (machine.u) q[machine.u->value] = tool.lift_mm;
  return q;
}

Vec3 to_machine(const Recipe& recipe, const config::Machine& machine, const WorkOffset& offset, const Surface& surface,
                Vec2 at, double height_mm) {
  const Vec3 origin = frame_origin(recipe, machine);
  const Vec2 p = on_frame(recipe, offset, at);
  return {origin.x + p.x, origin.y + p.y, origin.z + recipe.board.thickness + surface.at(at) + height_mm};
}

Vec3 purge_tip(const Recipe& recipe, const config::Machine& machine, const WorkOffset& offset, const Surface& surface) {
  const Purge& purge = *recipe.purge;
  if (purge.frame.empty()) {
    const Material* material = find_material(recipe, purge.material);
    return to_machine(recipe, machine, offset, surface, flat(purge.at), purge.at.z + (material ? material->gap : 0));
  }
  const config::WorkFrame* frame = config::find_frame(machine, purge.frame);
  return (frame ? frame->origin : Vec3{}) + purge.at;
}

std::vector<config::Body> bodies(const Recipe& recipe, const config::Machine& machine, const WorkOffset& offset,
                                 const Surface& surface) {
  const Vec3 origin = frame_origin(recipe, machine);
  const auto on = [&](Vec2 p, double z) { return Vec3{origin.x + p.x, origin.y + p.y, origin.z + z}; };
  const Vec2 middle = recipe.board.size * 0.5;
  std::vector<config::Body> out;
  out.push_back(upright_box("board", on(on_frame(recipe, offset, middle), 0),
                            {recipe.board.size.x, recipe.board.size.y, recipe.board.thickness + surface.at(middle)},
                            offset.rotation));
  for (const Part& part : recipe.parts)
    if (part.fixture)
      out.push_back(upright_box(part.name, below_fixture(recipe, machine, part), part.size, part.rotation));
    else
      out.push_back(upright_box(part.name,
                                on(on_frame(recipe, offset, part.at), recipe.board.thickness + surface.at(part.at)),
                                part.size, part.rotation + offset.rotation));
  return out;
}

std::vector<config::Body> zones(const Recipe& recipe, const config::Machine& machine) {
  std::vector<config::Body> out;
  for (const Part& zone : recipe.keep_out) {
    out.push_back(
        upright_box(config::zone_name(zone.name), below_fixture(recipe, machine, zone), zone.size, zone.rotation));
    out.back().keep_out = true;
  }
  return out;
}

}  // namespace gantry::recipes
