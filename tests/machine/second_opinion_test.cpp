// A whole job of which FCL is asked as well: it plays the same, and one word against a motion ends it before that.
#include <algorithm>

#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using test::Rig;

record::JobResult run_with(Rig& rig, const recipes::Recipe& recipe, motion::Opinion opinion) {
  const auto job = recipes::compile(recipe, rig.machine());
  EXPECT_TRUE(job);
  EXPECT_TRUE(rig.owner().bring_up());
  return rig.owner().run(recipe, *job, {.out = "", .dry_run = true, .opinion = std::move(opinion)});
}

TEST(SecondOpinion, of_a_placed_board_changes_nothing_of_the_job) {
  const recipes::Recipe recipe = test::load_recipe("recipes/demo-board.yaml");
  const test::RigOptions placed{.placement = "dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg"};
  Rig with(placed), without(placed);
  const record::JobResult a = run_with(with, recipe, motion::fcl_opinion()), b = run_with(without, recipe, {});
  ASSERT_TRUE(a.errors.empty()) << to_text(a.errors.front());
  EXPECT_EQ(a.setpoint_hash, b.setpoint_hash);
  EXPECT_GT(a.opinion_poses, a.motions_certified);
  EXPECT_EQ(b.opinion_poses, 0u);
}

/// The proof knows of no wall across the board's middle; FCL is shown one.
TEST(SecondOpinion, against_a_motion_of_the_placed_board_ends_the_job_before_that_motion) {
  const recipes::Recipe recipe = test::load_recipe("recipes/demo-board.yaml");
  Rig rig({.placement = "dx=1 mm"});
  const auto x = rig.machine().x.value;
  const double wall_x = recipes::to_machine(recipe, rig.machine(), {}, {}, {60, 0}, 0).x;
  double furthest = 0;
  rig.owner().on_step([&] {
    if (rig.owner().latest().state == cycle::State::Running)
      furthest = std::max(furthest, rig.owner().latest().target[x]);
  });
  const record::JobResult r = run_with(
      rig, recipe,
      [&, fcl = motion::fcl_opinion()](const motion::Scene& scene, const motion::PathRules& rules,
                                       std::span<const motion::Segment> all) {
        motion::Scene real = scene;
        real.add(config::Body{"wall", {config::Shape::Kind::Box, {4, 1000, 1000}}, {wall_x + 100, 0, 0}, 0, false});
        return fcl(real, rules, all);
      });
  rig.owner().on_step({});
  ASSERT_FALSE(r.errors.empty());
  EXPECT_EQ(r.errors.front().fault, Fault::Internal) << to_text(r.errors.front());
  EXPECT_NE(r.errors.front().message.find("wall"), std::string::npos);
  EXPECT_EQ(r.errors.front().where.find("recipes/demo-board.yaml:"), 0u) << to_text(r.errors.front());
  EXPECT_EQ(r.exit_code, ExitCode::Internal);
  EXPECT_EQ(r.features_done, 0u);
  EXPECT_LT(furthest, wall_x + 100);
}

}  // namespace
}  // namespace gantry
