// The reference machine runs the demo recipe in virtual time; the world, not the controller, says what lies on the
// board.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <set>

#include "core/units.hpp"
#include "tests/machine/deposits.hpp"

namespace gantry {
namespace {

using test::expect_deposits;
using test::expect_done;
using test::Rig;

using test::kDemo;

TEST(DemoBoard, every_feature_lies_where_the_recipe_wants_it) {
  const recipes::Recipe recipe = test::load_recipe(kDemo);
  Rig rig({.placement = "dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg"});
  const record::JobResult result = rig.run(recipe);
  expect_done(result);
  expect_deposits(recipe, result);
  EXPECT_TRUE(result.collisions.empty());
  EXPECT_TRUE(result.setpoint_stream_complete);
  EXPECT_FALSE(result.disturbed);
  EXPECT_NEAR(result.offset.shift.x, 1.3, 0.005);
  EXPECT_NEAR(result.offset.shift.y, -0.7, 0.005);
  EXPECT_NEAR(result.offset.rotation, units::rad(0.8), 1e-4);
  EXPECT_EQ(result.features_done, recipe.features.size());
  EXPECT_GT(result.actual_s, 30);
  EXPECT_LT(result.actual_s, 90);
}

TEST(DemoBoard, any_placement_within_two_millimetres_and_one_and_a_half_degrees) {
  const recipes::Recipe recipe = test::load_recipe(kDemo);
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> shift(-2, 2), turn(-1.5, 1.5);
  std::vector<std::string> placements{"dx=2 mm, dy=2 mm, rot=1.5 deg", "dx=-2 mm, dy=-2 mm, rot=-1.5 deg",
                                      "dx=2 mm, dy=-2 mm, rot=1.5 deg"};
  for (int i = 0; i < 5; ++i)
    placements.push_back(
        fmt::format("dx={:.3f} mm, dy={:.3f} mm, rot={:.3f} deg", shift(random), shift(random), turn(random)));
  std::uint64_t seed = 100;
  for (const std::string& placement : placements) {
    SCOPED_TRACE(placement);
    Rig rig({.placement = placement, .script = {}, .seed = ++seed});
    const record::JobResult result = rig.run(recipe);
    expect_done(result);
    expect_deposits(recipe, result);
    EXPECT_TRUE(result.collisions.empty());
  }
}

TEST(DemoBoard, a_run_is_a_pure_function_of_its_inputs) {
  std::set<std::uint64_t> hashes;
  for (int i = 0; i < 2; ++i) {
    Rig rig({.placement = "dx=-0.4 mm, dy=0.9 mm, rot=-0.6 deg"});
    hashes.insert(rig.run(kDemo).setpoint_hash);
  }
  EXPECT_EQ(hashes.size(), 1u);
  Rig elsewhere({.placement = "dx=-0.4 mm, dy=0.9 mm, rot=-0.5 deg"});
  hashes.insert(elsewhere.run(kDemo).setpoint_hash);
  EXPECT_EQ(hashes.size(), 2u) << "another placement must give another stream";
}

/// Four marks, three touches with their retracts, one block of features, parking. Of all but the retracts, which begin
/// where the probe has touched, it is known beforehand where they begin. The same stream comes out of a machine with
/// two touches a point: there the slow one is foreseen, too.
TEST(DemoBoard, every_block_is_proved_ahead_but_what_begins_at_a_touch) {
  for (const bool two : {false, true}) {
    Rig rig({.placement = "dx=-0.4 mm, dy=0.9 mm, rot=-0.6 deg", .change = [&](config::Machine& m) {
               if (two) m.probe.fast_mm_s = 2 * m.probe.speed_mm_s, m.probe.back_off_mm = 1;
             }});
    const record::JobResult result = rig.run(kDemo);
    expect_done(result);
    EXPECT_EQ(result.proofs, (job::ProofsAhead{two ? 12u : 9u, two ? 6u : 3u, 0, 0}));
  }
}

TEST(DemoBoard, what_is_seen_late_changes_no_setpoint) {
  std::set<std::uint64_t> hashes;
  for (const char* disturbed : {"", "- {at: mark back_right, do: noise, loss: 0.3, seed: 1}",
                                "- {at: mark back_right, do: noise, loss: 0.3, seed: 2}"}) {
    Rig rig({.placement = "dx=-0.4 mm, dy=0.9 mm, rot=-0.6 deg", .script = disturbed, .change = [](config::Machine& m) {
               m.bus.frames_lost_max = 30;
             }});
    const record::JobResult result = rig.run(kDemo);
    // A valve whose command is lost for some cycles shuts, or opens, that much later: the world says of which dots.
    for (const record::Defect& d : result.defects) {
      EXPECT_EQ(d.kind, record::Defect::Kind::Amount) << d.feature << ": " << d.message;
      const auto its = std::find_if(result.deposits.begin(), result.deposits.end(),
                                    [&](const record::Deposit& deposit) { return deposit.id == d.feature; });
      ASSERT_NE(its, result.deposits.end());
      EXPECT_TRUE(its->open_s < 0.057 || its->open_s > 0.063) << d.feature << ": " << d.message;
    }
    EXPECT_TRUE(*disturbed != 0 || result.defects.empty());
    EXPECT_EQ(result.exit_code, result.defects.empty() ? ExitCode::Done : ExitCode::DoneWithDefects);
    EXPECT_EQ(result.cycles.frames_lost > 10000, *disturbed != 0);
    hashes.insert(result.setpoint_hash);
  }
  EXPECT_EQ(hashes.size(), 1u);
}

}  // namespace
}  // namespace gantry
