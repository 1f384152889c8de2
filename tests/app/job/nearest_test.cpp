// The two figures of a proof: the nearest pair by design and the nearest of all others, by closed forms.
#include "app/job/nearest.hpp"

#include <gtest/gtest.h>

#include "app/job/prove.hpp"
#include "tests/app/job/reference.hpp"
#include "tests/motion/plan/prism_distance.hpp"

namespace gantry::job {
namespace {

constexpr const char* kTouches =
    "touches:\n  t0: {at: [10 mm, 10 mm]}\n  t1: {at: [70 mm, 10 mm]}\n  t2: {at: [40 mm, 45 mm]}\n"
    "touch_rules: {window: 1.5 mm}\n";

struct NearestTest : testing::Test {
  config::Machine machine = test::reference();
  recipes::Recipe recipe = test::dots(1, 1);
  Clearances proved() {
    const auto job = recipes::compile(recipe, machine);
    EXPECT_TRUE(job);
    const auto proof = prove_nominal(machine, recipe, *job);
    EXPECT_TRUE(proof) << to_text(proof.error());
    return proof ? proof->nearest : Clearances{};
  }
};

TEST_F(NearestTest, the_needle_over_its_board_hides_no_other_pair) {
  // 2.25 mm beside the needle (radius 0.8 mm) over the only dot, at (10, 10) mm
  recipe.parts.push_back({.name = "relay", .at = {10 + 0.8 + 2.25 + 2, 10}, .size = {4, 4, 3}, .location = {}});
  const Clearances n = proved();
  ASSERT_TRUE(n.by_design && n.others);
  EXPECT_NEAR(n.by_design->distance_mm, 0.5, 1e-6) << "the material's gap";
  EXPECT_EQ(n.by_design->head + " " + n.by_design->standing, "needle board");
  EXPECT_EQ(n.by_design->motion, "down to dot 'd[0][0]'");
  EXPECT_EQ(n.by_design->where.rfind("dots.yaml:", 0), 0u) << n.by_design->where;
  EXPECT_NEAR(n.others->distance_mm, 2.1, 1e-6) << "the plate under a board of 1.6 mm and the gap";
  EXPECT_EQ(n.others->standing, "pallet_plate");
  recipe.board.thickness = 5;
  const Clearances thick = proved();
  ASSERT_TRUE(thick.others);
  EXPECT_NEAR(thick.others->distance_mm, 2.25, 1e-6);
  EXPECT_EQ(thick.others->head + " " + thick.others->standing, "needle relay");
  EXPECT_NEAR(thick.others->board_mm->x, 10 + 0.8 + 2.25, 1e-6) << "the relay's left side";
  const Vec3 origin = config::find_frame(machine, "pallet")->origin;
  EXPECT_NEAR(thick.others->machine_mm.x, origin.x + 10 + 0.8 + 2.25, 1e-6);
}

TEST_F(NearestTest, a_touch_is_told_by_how_far_below_the_surface_it_is_planned) {
  recipe = test::dots(1, 1, kTouches);
  const Clearances n = proved();
  ASSERT_TRUE(n.by_design && n.others);
  EXPECT_NEAR(n.by_design->distance_mm, -1.5, 1e-6);
  EXPECT_EQ(n.by_design->head + " " + n.by_design->standing, "probe_stylus board");
  EXPECT_EQ(n.by_design->motion, "probe down at touch 't0'");
  EXPECT_LT(n.others->distance_mm, 100) << "there is always another pair";
}

TEST(Nearest, is_said_in_the_board_s_coordinates_with_the_machine_s_in_brackets) {
  const Nearest n{2.5, "needle", "relay", "down to dot 'd'", "board.yaml:6:3", {192, 158, -107}, Vec3{12, 8, 3}};
  EXPECT_EQ(to_text(n),
            "2.500 mm, needle and relay, down to dot 'd' (board.yaml:6:3), at (12.00, 8.00, 3.00) mm [machine 192.00, "
            "158.00, -107.00]");
  EXPECT_EQ(to_text(std::nullopt), "no such pair");
}

}  // namespace
}  // namespace gantry::job
