#include "app/job/rise.hpp"

#include <gtest/gtest.h>

#include "app/job/block_plan.hpp"
#include "motion/geometry.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

struct RiseTest : testing::Test {
  config::Machine machine = test::reference();
  AxisVec at(double z) {
    AxisVec q = test::parked(machine);
    q[machine.x.value] = 200, q[machine.y.value] = 150, q[machine.z.value] = z;
    return q;
  }
};

TEST_F(RiseTest, goes_straight_up_to_the_safe_height_and_nowhere_from_there) {
  const Surroundings bodies(machine);
  const AxisVec low = at(machine.safe_z_mm - 10);
  const auto up = plan_rise(machine, bodies, 1, low);
  ASSERT_TRUE(up) << to_text(up.error());
  ASSERT_TRUE(*up);
  AxisVec end = low;
  end[machine.z.value] = machine.safe_z_mm;
  EXPECT_EQ((*up)->end(), end);
  EXPECT_GE((*up)->motions(), 1u) << "it was proved";
  const auto none = plan_rise(machine, bodies, 1, end);
  ASSERT_TRUE(none);
  EXPECT_FALSE(*none);
}

TEST_F(RiseTest, is_refused_under_an_overhang_with_both_bodies_and_the_way_out) {
  const motion::Scene scene(machine);
  const motion::SceneBody& body = scene.head().front();
  const AxisVec low = at(machine.safe_z_mm - 20);
  config::Body roof{"roof", {config::Shape::Kind::Box, {500, 500, 2}}, {}, 0, false};
  roof.centre = body.solid.centre + scene.carried(body, low);
  for (const motion::SceneBody& each : scene.head())
    roof.centre.z = std::max(roof.centre.z, each.solid.centre.z + each.half_box.z + scene.carried(each, low).z);
  roof.centre.z += 10;
  machine.scene.push_back(roof);
  const auto up = plan_rise(machine, Surroundings(machine), 1, low);
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::Collision);
  for (const char* word : {"roof", "within", "jog"})
    EXPECT_NE(up.error().message.find(word), std::string::npos) << up.error().message;
}

/// Wherever a job can be stopped, the head can rise afterwards: from the needle over a dot beside a part, too.
TEST_F(RiseTest, is_possible_from_wherever_a_job_has_brought_the_head) {
  const auto recipe = recipes::load("recipes/demo-board.yaml");
  ASSERT_TRUE(recipe);
  const auto job = recipes::compile(*recipe, machine);
  ASSERT_TRUE(job);
  BlockPlanner planner(machine, *recipe);
  Knowledge known;
  known.offset = recipes::WorkOffset{};
  known.surface = recipes::Surface{};
  planner.know(known);
  std::vector<std::size_t> all(recipe->features.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const auto block = planner.dispense(1, test::parked(machine), all);
  ASSERT_TRUE(block) << to_text(block.error());
  int risen = 0;
  for (const motion::Segment& s : block->segments()) {
    const AxisVec here = motion::point(s.geometry, s.geometry.length);
    if (here[machine.z.value] >= machine.safe_z_mm) continue;
    const auto up = plan_rise(machine, *planner.surroundings(), 1, here);
    ASSERT_TRUE(up) << to_text(up.error());
    risen += up->has_value();
  }
  EXPECT_GT(risen, 30);
}

}  // namespace
}  // namespace gantry::job
