#include "sim/world/board.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

constexpr double kDeg = std::numbers::pi / 180;

TEST(PlacementText, reads_shift_and_rotation_with_missing_parts_zero) {
  const auto p = parse_placement("dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg");
  ASSERT_TRUE(p) << p.error().message;
  EXPECT_DOUBLE_EQ(p->shift.x, 1.3);
  EXPECT_DOUBLE_EQ(p->shift.y, -0.7);
  EXPECT_NEAR(p->rotation_rad, 0.8 * kDeg, 1e-15);
  EXPECT_FALSE(p->z0_mm);
  const auto only = parse_placement("dy=2mm");
  ASSERT_TRUE(only) << only.error().message;
  EXPECT_DOUBLE_EQ(only->shift.x, 0);
  EXPECT_DOUBLE_EQ(only->shift.y, 2);
}

TEST(PlacementText, names_the_mistake_and_its_column) {
  const struct {
    const char* text;
    Fault fault;
    const char* where;
  } cases[] = {
      {"dx=1.3 mm, dq=1 mm", Fault::UnknownKey, "--sim-board:1:12"},
      {"dx=1.3", Fault::BadUnit, "--sim-board:1:1"},
      {"dx=1 mm, dy=2001 mm", Fault::OutOfRange, "--sim-board:1:10"},
      {"rot=361 deg", Fault::OutOfRange, "--sim-board:1:1"},
      {"dx=1 mm, dx=2 mm", Fault::DuplicateKey, "--sim-board:1:10"},
      {"dx", Fault::BadValue, "--sim-board:1:1"},
      {"", Fault::BadValue, "--sim-board:1:1"},
      {"dx=1 mm,", Fault::BadValue, "--sim-board:1:9"},
      {"rot=1 mm", Fault::BadUnit, "--sim-board:1:1"},
  };
  for (const auto& c : cases) {
    const auto p = parse_placement(c.text);
    ASSERT_FALSE(p) << c.text;
    EXPECT_EQ(p.error().fault, c.fault) << c.text << ": " << p.error().message;
    EXPECT_EQ(p.error().where, c.where) << c.text;
  }
}

TEST(BoardPlacement, is_drawn_within_the_spreads_and_again_from_the_same_seed) {
  const auto truth = sample::machine().sim;
  double most = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const BoardPlacement p = draw_placement(truth, seed, 0, std::nullopt);
    EXPECT_LE(std::abs(p.shift.x), truth.placement_spread_mm);
    EXPECT_LE(std::abs(p.shift.y), truth.placement_spread_mm);
    EXPECT_LE(std::abs(p.rotation_rad), truth.placement_spread_rad);
    EXPECT_LE(std::abs(p.z0_mm), truth.height_spread_mm);
    most = std::max(most, std::abs(p.shift.x));
    const BoardPlacement again = draw_placement(truth, seed, 0, std::nullopt);
    EXPECT_EQ(p.shift, again.shift);
    EXPECT_NE(draw_placement(truth, seed, 1, std::nullopt).shift, p.shift) << "the next board lies elsewhere";
  }
  EXPECT_GT(most, 0.9 * truth.placement_spread_mm);
}

TEST(BoardPlacement, text_sets_what_it_names_and_the_seed_the_rest) {
  const auto truth = sample::machine().sim;
  const BoardPlacement drawn = draw_placement(truth, 7, 0, std::nullopt);
  const BoardPlacement p = draw_placement(truth, 7, 0, *parse_placement("dx=1 mm"));
  EXPECT_EQ(p.shift, (Vec2{1, 0}));
  EXPECT_EQ(p.rotation_rad, 0);
  EXPECT_EQ(p.z0_mm, drawn.z0_mm);
  EXPECT_EQ(p.slope, drawn.slope);
  const auto read_back = parse_placement(to_text(p));
  ASSERT_TRUE(read_back) << to_text(p);
  EXPECT_NEAR(*read_back->z0_mm, p.z0_mm, 1e-6);
}

TEST(BoardTruth, turns_about_the_boards_origin_then_shifts) {
  // Judge: Eigen's isometries.
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  const BoardPlan plan = board_plan(sample::recipe());
  const Vec3 origin{100, 80, 5};
  for (int n = 0; n < 1000; ++n) {
    BoardPlacement p;
    p.shift = {2 * unit(random), 2 * unit(random)};
    p.rotation_rad = unit(random) * 0.1;
    p.z0_mm = unit(random);
    p.slope = {unit(random) * 1e-3, unit(random) * 1e-3};
    const BoardTruth board(plan, origin, p);
    const Vec2 at{60 + 60 * unit(random), 40 + 40 * unit(random)};
    const double h = unit(random);
    const Eigen::Vector2d flat = Eigen::Translation2d(origin.x + 20 + p.shift.x, origin.y + 10 + p.shift.y) *
                                 (Eigen::Rotation2Dd(p.rotation_rad) * Eigen::Vector2d(at.x, at.y));
    const Vec3 m = board.to_machine(at, h);
    EXPECT_NEAR(m.x, flat.x(), 1e-12);
    EXPECT_NEAR(m.y, flat.y(), 1e-12);
    EXPECT_NEAR(m.z, 5 + 1.6 + p.z0_mm + p.slope.x * at.x + p.slope.y * at.y + h, 1e-12);
    const Vec3 back = board.to_board(m);
    EXPECT_NEAR(back.x, at.x, 1e-12);
    EXPECT_NEAR(back.y, at.y, 1e-12);
    EXPECT_NEAR(back.z, h, 1e-12);
  }
}

TEST(Solids, parts_move_with_the_board_and_fixtures_do_not) {
  const config::Machine m = sample::machine();
  BoardPlacement moved;
  moved.shift = {1.5, -0.5};
  moved.rotation_rad = 0.02;
  moved.z0_mm = 0.4;
  const BoardTruth nominal(board_plan(sample::recipe()), {100, 80, 0}, {});
  const BoardTruth board(board_plan(sample::recipe()), {100, 80, 0}, moved);
  const auto before = solids_of(m.scene, &nominal), after = solids_of(m.scene, &board);
  ASSERT_EQ(before.size(), 5u);  // pallet, post, board, relay, clamp
  EXPECT_EQ(after[3].name, "relay");
  EXPECT_EQ(after[4].name, "clamp");
  EXPECT_EQ(after[4].centre, before[4].centre);
  EXPECT_NEAR(after[4].centre.z, 6, 1e-12) << "12 mm from the pallet up";
  EXPECT_EQ(after[4].rotation_rad, before[4].rotation_rad);
  EXPECT_NEAR(after[3].rotation_rad - before[3].rotation_rad, 0.02, 1e-15);
  const Vec2 turned = rotated({60, 40}, 0.02) + Vec2{120 + 1.5, 90 - 0.5};
  EXPECT_NEAR(after[3].centre.x, turned.x, 1e-12);
  EXPECT_NEAR(after[3].centre.y, turned.y, 1e-12);
  EXPECT_NEAR(after[3].centre.z, 1.6 + 0.4 + 7.5, 1e-12);
  EXPECT_EQ(solids_of(m.scene, nullptr).size(), 2u);
}

}  // namespace
}  // namespace gantry::sim
