// Boxes and cylinders that are in one another, against points that both hold.
#include "config/upright.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace gantry::config {
namespace {

bool holds(const Upright& body, Vec2 p) {
  const Vec2 q = rotated(p - body.centre, -body.rotation_rad);
  return body.round ? norm(q) <= body.half.x : std::abs(q.x) <= body.half.x && std::abs(q.y) <= body.half.y;
}

TEST(Upright, agrees_with_a_search_for_a_point_in_both) {
  constexpr unsigned kSeed = 3;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> at(-12, 12), half(1, 6), turn(-3, 3);
  int in = 0, out = 0;
  for (int round = 0; round < 600; ++round) {
    Upright a{{0, 0}, {half(random), half(random)}, 0, 0, 10};
    Upright b{{at(random), at(random)}, {half(random), half(random)}, turn(random), 5, 9, round % 3 == 0};
    if (b.round) b.half.y = b.half.x;
    a.round = round % 6 == 0;
    if (a.round) a.half.y = a.half.x;
    bool found = false;
    constexpr double kStep = 0.1;
    for (double x = -a.half.x; x <= a.half.x && !found; x += kStep)
      for (double y = -a.half.y; y <= a.half.y && !found; y += kStep) found = holds(a, {x, y}) && holds(b, {x, y});
    // Grazing pairs are within the search's step of either answer.
    EXPECT_TRUE(!found || in_one_another(a, b, 0)) << "seed " << kSeed << " round " << round;
    EXPECT_FALSE(!found && in_one_another(a, b, 3 * kStep)) << "seed " << kSeed << " round " << round;
    EXPECT_EQ(in_one_another(a, b, 0.05), in_one_another(b, a, 0.05));
    (found ? in : out) += 1;
    b.low = 10, b.high = 12;
    EXPECT_FALSE(in_one_another(a, b, 0)) << "it stands on the other";
  }
  EXPECT_GT(in, 100);
  EXPECT_GT(out, 100);
}

}  // namespace
}  // namespace gantry::config
