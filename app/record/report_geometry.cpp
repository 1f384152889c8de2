#include "app/record/report_geometry.hpp"

namespace gantry::record {

Vec2 to_board(const JobResult& r, Vec2 nominal) {
  return r.has_offset ? rotated(nominal - r.offset.shift, -r.offset.rotation) : nominal;
}

Vec3 machine_to_board(const JobResult& r, Vec3 p) {
  const Vec3 nominal = p - r.drawing.board_origin;
  const Vec2 flat = to_board(r, {nominal.x, nominal.y});
  return {flat.x, flat.y, nominal.z};
}

Vec3 machine_tip_at(const JobResult& r, const PathPoint& p) {
  const Drawing& d = r.drawing;
  Vec3 tip = p.block < d.tip_of_block.size() ? d.tip_of_block[p.block] : Vec3{};
  // While it goes up or down the lift carries the tip higher than where it works.
  if (d.lifted_at_mm != 0 && tip == d.lifted_tip) tip.z += d.lifted_at_mm - p.lift_mm;
  return p.head + tip;
}

Vec3 tip_at(const JobResult& r, const PathPoint& p) { return machine_to_board(r, machine_tip_at(r, p)); }

}  // namespace gantry::record
