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
  const auto box = [&](std::string name, Vec2 centre, double z, Vec3 size, double rotation) {
    return config::Body{std::move(name),
                        {config::Shape::Kind::Box, size},
                        {origin.x + centre.x, origin.y + centre.y, origin.z + z + size.z / 2},
                        rotation,
                        false};
  };
  const Vec2 middle = recipe.board.size * 0.5;
  std::vector<config::Body> out;
  out.push_back(box("board", on_frame(recipe, offset, middle), 0,
                    {recipe.board.size.x, recipe.board.size.y, recipe.board.thickness + surface.at(middle)},
                    offset.rotation));
  for (const Part& part : recipe.parts) {
    if (part.fixture)
      out.push_back(box(part.name, part.at + recipe.board.at, part.underside, part.size, part.rotation));
    else
      out.push_back(box(part.name, on_frame(recipe, offset, part.at), recipe.board.thickness + surface.at(part.at),
                        part.size, part.rotation + offset.rotation));
  }
  return out;
}

}  // namespace gantry::recipes
