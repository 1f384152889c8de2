// The rows of proved motions, read as anybody would read them, against closed forms that share nothing with the proof
// (tests/motion/plan/prism_distance.hpp).
#include "app/job/motion_rows.hpp"

#include <gtest/gtest.h>
#include <map>
#include <sstream>

#include "app/job/block_plan.hpp"
#include "app/job/surroundings.hpp"
#include "tests/app/job/random_board.hpp"
#include "tests/app/job/reference.hpp"
#include "tests/motion/plan/prism_distance.hpp"

namespace gantry::job {
namespace {

using Row = std::map<std::string, std::string>;

std::vector<std::string> cut(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  for (const char c : line + ",")
    if (c == ',')
      cells.push_back(cell), cell.clear();
    else
      cell += c;
  return cells;
}

std::vector<Row> rows_of(const config::Machine& machine, const ProvenBlock& block) {
  std::string text = MotionRows(machine).heading();
  for (const std::string& piece : block.rows()) text += piece;
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  const auto keys = cut(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    const auto cells = cut(line);
    EXPECT_EQ(cells.size(), keys.size()) << line;
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < std::min(cells.size(), keys.size()); ++i) row[keys[i]] = cells[i];
  }
  return rows;
}

AxisVec end_of(const config::Machine& machine, Row row, const std::string& which) {
  AxisVec q{};
  for (const config::Axis& axis : machine.axes)
    if (axis.kind == config::AxisKind::Streamed)
      q[axis.id.value] = axis.rotary ? std::stod(row.at(which + "_" + axis.name + "_deg")) * M_PI / 180
                                     : std::stod(row.at(which + "_" + axis.name + "_mm"));
  return q;
}

config::Body judged(const motion::SceneBody& body) {
  using K = motion::Solid::Kind;
  const motion::Solid& s = body.solid;
  const double r = s.half.x;
  const Vec3 size = s.kind == K::Capsule ? Vec3{2 * r, 2 * r, 2 * (s.half.z + r)} : s.half * 2;
  const auto kind = s.kind == K::Box        ? config::Shape::Kind::Box
                    : s.kind == K::Cylinder ? config::Shape::Kind::Cylinder
                                            : config::Shape::Kind::Capsule;
  return {body.name, {kind, size}, s.centre, std::atan2(s.sin, s.cos), body.on_lift};
}

/// Of a motion: of one pair, or the least of all.
double least_mm(const motion::Scene& scene, const AxisVec& from, const AxisVec& to, const std::string& head = "",
                const std::string& standing = "") {
  double least = 1e9;
  for (const motion::SceneBody& h : scene.head()) {
    if (!head.empty() && h.name != head) continue;
    config::Body body = judged(h);
    const Vec3 start = scene.carried(h, from);
    body.centre = body.centre + start;
    for (const motion::SceneBody& s : scene.standing())
      if (standing.empty() || s.name == standing)
        least = std::min(least, test::swept_distance(body, scene.carried(h, to) - start, judged(s)));
  }
  return least;
}

TEST(MotionRows, have_a_column_for_each_axis_of_coordinated_motion) {
  EXPECT_EQ(MotionRows(test::reference()).heading(),
            "block,motion,where,from_X_mm,from_Y_mm,from_Z_mm,from_C_deg,from_U_mm,to_X_mm,to_Y_mm,to_Z_mm,to_C_deg,"
            "to_U_mm,clearance_mm,head,standing,by_design_mm,by_design_head,by_design_standing\n");
}

TEST(MotionRows, every_motion_of_random_boards_stands_there_with_its_nearest_pair) {
  const config::Machine reference = test::reference();
  std::size_t motions = 0, by_design = 0;
  for (std::uint64_t number = 0; number < 40; ++number) {
    const test::RandomBoard board = test::random_board(reference, number);
    BlockPlanner planner(board.machine, board.recipe), unlisted(board.machine, board.recipe);
    Knowledge nominal;
    nominal.offset = recipes::WorkOffset{}, nominal.surface = recipes::Surface{};
    planner.know(nominal), unlisted.know(nominal);
    planner.list_motions();
    const AxisVec park = test::parked(board.machine);
    for (std::size_t f = 0; f < board.recipe.features.size(); ++f) {
      const auto block = planner.dispense(7, park, {f}), plain = unlisted.dispense(7, park, {f});
      ASSERT_EQ(block.has_value(), plain.has_value());
      if (!block) continue;
      EXPECT_TRUE(plain->rows().empty());
      EXPECT_EQ(plain->duration_s(), block->duration_s());
      EXPECT_EQ(plain->nearest().others->distance_mm, block->nearest().others->distance_mm)
          << "listing changes nothing";
      const motion::Scene& scene = planner.surroundings()->scene();
      const auto rows = rows_of(board.machine, *block);
      ASSERT_EQ(rows.size(), block->motions());
      AxisVec at = park;
      double least_other = 1e9;
      const std::string id = "'" + recipes::id_of(board.recipe.features[f]) + "'";
      for (const Row& row : rows) {
        EXPECT_EQ(row.at("block"), "7");
        EXPECT_NE(row.at("motion").find(id), std::string::npos) << row.at("motion");
        EXPECT_EQ(row.at("where").rfind(board.recipe.file + ":", 0), 0u) << row.at("where");
        const AxisVec from = end_of(board.machine, row, "from"), to = end_of(board.machine, row, "to");
        for (const config::Axis& axis : board.machine.axes) EXPECT_NEAR(from[axis.id.value], at[axis.id.value], 1e-6);
        at = to;
        double told = 1e9;
        for (const auto& [mm, head, standing] : {std::tuple{"clearance_mm", "head", "standing"},
                                                 std::tuple{"by_design_mm", "by_design_head", "by_design_standing"}}) {
          if (row.at(mm).empty()) continue;
          const double distance = std::stod(row.at(mm));
          EXPECT_NEAR(distance, least_mm(scene, from, to, row.at(head), row.at(standing)), 3e-6);
          told = std::min(told, distance);
        }
        EXPECT_NEAR(told, least_mm(scene, from, to), 3e-6) << row.at("motion") << ", board " << number;
        least_other = std::min(least_other, std::stod(row.at("clearance_mm")));
        by_design += row.at("by_design_mm").empty() ? 0 : 1;
        ++motions;
      }
      for (const config::Axis& axis : board.machine.axes)
        EXPECT_NEAR(block->end()[axis.id.value], at[axis.id.value], 1e-6);
      EXPECT_NEAR(least_other, block->nearest().others->distance_mm, 1e-6);
    }
  }
  EXPECT_GT(motions, 200u);
  EXPECT_GT(by_design, 100u);
}

}  // namespace
}  // namespace gantry::job
