// A slice of the campaign (bench/plan/plan_campaign.cpp runs the long one).
#include "tests/motion/plan/plan_trial.hpp"

#include <array>
#include <gtest/gtest.h>

#include "tests/motion/plan/world_judge.hpp"

namespace gantry::test {
namespace {

TEST(PlanTrial, of_random_pairs_none_is_called_free_that_meets) {
  const PairTally t = try_pairs(40000, 1);
  std::printf("%d free, %d hits, %d close calls\n", t.free, t.hit, t.close_calls);
  EXPECT_EQ(t.false_free, 0);
  EXPECT_EQ(t.false_hits, 0);
  EXPECT_EQ(t.disagreements, 0);
  EXPECT_GT(t.free, 10000);
  EXPECT_GT(t.hit, 5000);
}

TEST(PlanTrial, the_world_judges_contact_clearance_and_what_leans) {
  config::Machine m;
  m.x = AxisId{0}, m.y = AxisId{1}, m.z = AxisId{2};
  m.head = {{"needle", {config::Shape::Kind::Capsule, {0.2, 0.2, 12}}, {0, 0, 6}, 0, false}};
  const auto meets = [&](const Stands& stands, double clearance, Vec3 from, Vec3 to) {
    m.clearance_mm = clearance;
    return WorldJudge(m, {stands.truly})
        .collides(std::array<AxisVec, 2>{AxisVec{from.x, from.y, from.z}, AxisVec{to.x, to.y, to.z}});
  };
  const config::Body foil{"foil", {config::Shape::Kind::Box, {0.05, 10, 10}}, {50, 50, 5}, 0, false};
  EXPECT_TRUE(meets(upright(foil), 0, {40, 50, 2}, {60, 50, 2}));
  EXPECT_FALSE(meets(upright(foil), 0, {40, 55.101, 2}, {60, 55.101, 2}));  // beside it by the needle and 1 µm
  EXPECT_TRUE(meets(upright(foil), 0.5, {40, 55.59, 2}, {60, 55.59, 2}));
  EXPECT_FALSE(meets(upright(foil), 0.5, {40, 55.601, 2}, {60, 55.601, 2}));
  EXPECT_TRUE(meets(upright(foil), 0, {50, 50, 2}, {50, 50, 2}));
  // A plate of 20 x 20 x 2 that leans by 0.3 in X: its side at X + 10 is 2.9 mm higher, that at X - 10 as much lower.
  const Stands plate = leaning({"plate", {config::Shape::Kind::Box, {20, 20, 2}}, {50, 50, 20}, 0, false}, {0.3, 0});
  EXPECT_TRUE(meets(plate, 0, {58, 30, 22}, {58, 70, 22}));   // the needle goes from its tip up
  EXPECT_FALSE(meets(plate, 0, {42, 30, 22}, {42, 70, 22}));  // within the upright box about it, above the plate
  EXPECT_NEAR(plate.told.shape.size.z, 20 * 0.3 / std::sqrt(1.09) + 2 / std::sqrt(1.09), 1e-9);
}

TEST(PlanTrial, of_random_plans_none_collides_and_no_proof_is_wrong) {
  const PlanTally t = try_plans(300, 1);
  std::printf("%d paths, %d proved that there is none, %d ends collide, %d undecided\n", t.ok, t.no_path, t.taken,
              t.budget);
  EXPECT_EQ(t.colliding, 0);
  EXPECT_EQ(t.in_world, 0);
  EXPECT_EQ(t.unseen, 0);
  EXPECT_EQ(t.refused, 0);
  EXPECT_EQ(t.disproved, 0);
  EXPECT_EQ(t.longer, 0);
  EXPECT_EQ(t.different, 0);
  EXPECT_EQ(t.budget, 0);
  EXPECT_GT(t.ok, 80);
  EXPECT_GT(t.no_path, 10);
}

}  // namespace
}  // namespace gantry::test
