#include "app/record/drawing.hpp"

#include <gtest/gtest.h>

#include "app/record/deposit_figures.hpp"
#include "app/record/report_geometry.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

TEST(Drawing, knows_the_board_s_place_and_the_tool_of_each_block) {
  auto machine = three_axes();
  machine.frames = {{"pallet", {100, 80, 10}}};
  machine.tools = {{"needle", {0, 0, -60}, 5}, {"camera", {45, 0, -90}, 0}, {"probe", {-30, 10, -70}, 0}};
  recipes::Recipe recipe;
  recipe.board.size = {120, 80};
  recipe.board.thickness = 1.6;
  recipe.board.frame = "pallet";
  recipe.board.at = {3, 4};
  recipes::Bead bead;
  bead.id = "loop", bead.corner_tolerance = 0.2, bead.material = "glue";
  recipes::Material glue;
  glue.name = "glue", glue.tolerance_mm = 0.05, glue.gap_tolerance_mm = 0.03;
  recipe.materials = {glue};
  recipe.features = {bead};
  recipes::Job job;
  job.blocks = {{1, recipes::LookAtMark{0}}, {2, recipes::Touch{0}}, {3, recipes::Dispense{}}, {4, recipes::Park{}}};
  const auto d = drawing_of(recipe, machine, job);
  EXPECT_EQ(d.board_origin, (Vec3{103, 84, 11.6}));
  ASSERT_EQ(d.tip_of_block.size(), 5u);
  EXPECT_EQ(d.tip_of_block[1], (Vec3{45, 0, -90}));
  EXPECT_EQ(d.tip_of_block[2], (Vec3{-30, 10, -70}));
  EXPECT_EQ(d.tip_of_block[3], (Vec3{0, 0, -65}));
  EXPECT_DOUBLE_EQ(d.allowed.at("loop").beside_mm, 0.25);
  EXPECT_DOUBLE_EQ(d.allowed.at("loop").gap_mm, 0.03);

  JobResult r;
  r.drawing = d;
  PathPoint needle{.t_s = 0, .head = {103, 84, 100}, .block = 3, .valve = false, .lift_mm = 5};
  EXPECT_DOUBLE_EQ(tip_at(r, needle).z, 100 - 65 - 11.6);
  needle.lift_mm = 0;  // drawn where the needle really is, while the lift is still up
  EXPECT_DOUBLE_EQ(tip_at(r, needle).z, 100 - 60 - 11.6);
  needle.block = 1;  // the camera does not ride on the lift
  EXPECT_DOUBLE_EQ(tip_at(r, needle).z, 100 - 90 - 11.6);
  EXPECT_DOUBLE_EQ(allowed(r, {.id = "loop", .kind = "bead", .nominal_mm = {}, .board_mm = {}}).beside_mm, 0.25);
  EXPECT_DOUBLE_EQ(allowed(r, {.id = "", .kind = "dot", .nominal_mm = {}, .board_mm = {}}).beside_mm, 0.1);
}

TEST(Drawing, an_unknown_frame_or_tool_leaves_its_part_out) {
  recipes::Job job;
  job.blocks = {{1, recipes::Park{}}};
  const auto d = drawing_of(recipes::Recipe{}, three_axes(), job);
  EXPECT_EQ(d.board_origin, Vec3{});
  EXPECT_EQ(d.tip_of_block.size(), 2u);
}

}  // namespace
}  // namespace gantry::record
