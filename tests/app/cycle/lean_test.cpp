// The two sides of a beam that stand apart when they take torque: as the loop asks it, cycle by cycle.
#include "app/cycle/lean.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace gantry::cycle {
namespace {

constexpr double kSpeed = 2.5;  // mm/s

TEST(Lean, enable_moves_neither_side_and_a_motion_takes_out_what_they_stand_apart) {
  Lean lean;
  lean.see(0, 0.4, 0);
  EXPECT_DOUBLE_EQ(lean.of(0), -0.2);
  EXPECT_DOUBLE_EQ(lean.of(1), 0.2);
  for (int i = 0; i < 1000; ++i) lean.step(false, kSpeed, milliseconds(1), 1);
  EXPECT_DOUBLE_EQ(lean.of(1), 0.2) << "nothing moves";
  double before = lean.of(1), fastest = 0;
  int cycles = 0;
  for (; lean.of(1) != 0 && cycles < 10'000; ++cycles) {
    lean.see(0, 0.4, 2);
    lean.step(true, kSpeed, milliseconds(1), 1);
    EXPECT_LE(lean.of(1), before);
    fastest = std::max(fastest, 1000 * (before - lean.of(1)));
    before = lean.of(1);
  }
  EXPECT_LE(fastest, kSpeed / 2 * 1.001) << "of each side";
  EXPECT_NEAR(cycles, 240, 2) << "0.4 mm at 2.5 mm/s, half as long again";
}

// A side that takes its targets later than the other may be pushed until it does.
TEST(Lean, is_as_the_sides_stand_until_both_take_targets_and_no_longer_seen_until_neither_does) {
  Lean lean;
  lean.see(100, 100.1, 0);
  lean.see(100, 100.3, 1);
  EXPECT_NEAR(lean.of(1), 0.15, 1e-12);
  lean.see(100, 100.5, 2);
  EXPECT_NEAR(lean.of(1), 0.15, 1e-12);
  lean.see(100, 107, 1);
  EXPECT_NEAR(lean.of(1), 0.15, 1e-12) << "one has fallen out: it draws the other one nowhere";
  lean.see(100, 107, 0);
  EXPECT_NEAR(lean.of(1), 3.5, 1e-12);
}

TEST(Lean, that_a_stop_has_broken_off_goes_on_with_the_next_motion) {
  Lean lean;
  lean.see(0, 0.4, 0);
  for (int i = 0; i < 100; ++i) lean.step(true, kSpeed, milliseconds(1), 1);
  const double left = lean.of(1);
  EXPECT_GT(left, 0);
  EXPECT_LT(left, 0.2);
  for (int i = 0; i < 100; ++i) lean.step(false, kSpeed, milliseconds(1), 1);
  EXPECT_EQ(lean.of(1), left);
  for (int i = 0; i < 1000; ++i) lean.step(true, kSpeed, milliseconds(1), 1);
  EXPECT_EQ(lean.of(1), 0);
  EXPECT_EQ(lean.of(0), 0);
}

}  // namespace
}  // namespace gantry::cycle
