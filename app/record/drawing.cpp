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
  for (const auto& block : job.blocks) {
    const auto* tool = config::find_tool(machine, tool_of(block));
    if (d.tip_of_block.size() <= block.number) d.tip_of_block.resize(block.number + 1);
    // The lift lowers what rides on it while the tool works; on the way there the tip is a little higher than drawn.
    if (tool != nullptr) d.tip_of_block[block.number] = tool->tip - Vec3{0, 0, tool->lift_mm};
  }
  return d;
}

}  // namespace gantry::record
