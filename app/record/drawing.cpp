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

}  // namespace

Drawing drawing_of(const recipes::Recipe& recipe, const config::Machine& machine, const recipes::Job& job) {
  Drawing d;
  d.board_size = recipe.board.size;
  if (const auto* frame = config::find_frame(machine, recipe.board.frame))
    d.board_origin = frame->origin + Vec3{recipe.board.at.x, recipe.board.at.y, recipe.board.thickness};
  for (const auto& p : recipe.parts) d.parts.push_back({p.name, p.at, p.size, p.rotation, p.fixture});
  for (const auto& feature : recipe.features)
    if (const auto* bead = std::get_if<recipes::Bead>(&feature))
      d.corner_tolerance_mm[bead->id] = bead->corner_tolerance;
  for (const auto& tool : machine.tools)
    if (tool.lift_mm != 0) d.lifted_tip = tool.tip - Vec3{0, 0, tool.lift_mm}, d.lifted_at_mm = tool.lift_mm;
  for (const auto& block : job.blocks) {
    const auto* tool = config::find_tool(machine, tool_of(block));
    if (d.tip_of_block.size() <= block.number) d.tip_of_block.resize(block.number + 1);
    if (tool != nullptr) d.tip_of_block[block.number] = tool->tip - Vec3{0, 0, tool->lift_mm};
  }
  return d;
}

}  // namespace gantry::record
