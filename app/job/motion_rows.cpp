#include "app/job/motion_rows.hpp"

#include <cmath>
#include <fmt/format.h>
#include <iterator>

#include "core/units.hpp"

namespace gantry::job {
namespace {

constexpr std::size_t kPiece = 60'000;  // bytes

/// Nine digits are a nanometre within a metre; -0 is 0, and what is less than that is 0 too.
void add_number(std::string& row, double value) {
  constexpr double kNothing = 1e-9;
  fmt::format_to(std::back_inserter(row), ",{:.9g}", std::abs(value) < kNothing ? 0.0 : value);
}

void add_pair(std::string& row, const motion::Scene& scene, const motion::NearPair& pair) {
  if (!std::isfinite(pair.distance_mm)) return void(row += ",,,");
  add_number(row, pair.distance_mm);
  row += ',';
  row += scene.head()[pair.head].name;
  row += ',';
  row += scene.standing()[pair.standing].name;
}

}  // namespace

MotionRows::MotionRows(const config::Machine& machine) {
  for (const config::Axis& axis : machine.axes)
    if (axis.kind == config::AxisKind::Streamed)
      columns_.push_back(
          {axis.id.value, axis.name + (axis.rotary ? "_deg" : "_mm"), axis.rotary ? units::deg(1) : 1.0});
}

std::string MotionRows::heading() const {
  std::string row = "block,motion,where";
  for (const char* end : {"from", "to"})
    for (const Column& column : columns_) row += fmt::format(",{}_{}", end, column.name);
  return row + ",clearance_mm,head,standing,by_design_mm,by_design_head,by_design_standing\n";
}

void MotionRows::add(std::deque<std::string>& pieces, const Proved& proved) const {
  for (std::size_t i = 0; i < proved.nearest.size(); ++i) {
    if (pieces.empty() || pieces.back().size() > kPiece) pieces.emplace_back();
    std::string& row = pieces.back();
    fmt::format_to(std::back_inserter(row), "{},{},{}", proved.block, proved.motion, proved.where);
    for (const AxisVec* q : {&proved.points[i], &proved.points[i + 1]})
      for (const Column& column : columns_) add_number(row, (*q)[column.axis] * column.factor);
    add_pair(row, proved.scene, proved.nearest[i].others);
    add_pair(row, proved.scene, proved.nearest[i].by_design);
    row += '\n';
  }
}

}  // namespace gantry::job
