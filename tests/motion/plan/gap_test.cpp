// The swept query against closed forms (prism_distance.hpp).
#include "motion/plan/gap.hpp"

#include <gtest/gtest.h>

#include "tests/motion/plan/prism_distance.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

constexpr std::uint64_t kSeed = 4711;

TEST(Gap, of_standing_bodies_is_the_closed_form) {
  test::RandomBodies random(kSeed);
  double worst = 0;
  for (int i = 0; i < 40000; ++i) {
    const bool grid = i % 2 == 0;
    const config::Body a = random.body(20, grid), b = random.body(20, grid);
    const double truth = test::distance(a, b);
    const Gap g = measure_gap(make_solid(a), {}, make_solid(b));
    if (truth > 1e-6) {
      ASSERT_LE(g.lower, truth + 1e-9) << "case " << i << " seed " << kSeed;
      ASSERT_GE(g.upper, truth - 1e-9) << "case " << i << " seed " << kSeed;
      worst = std::max(worst, g.upper - g.lower);
      config::Body point{
          "point", {config::Shape::Kind::Box, {}}, nearest_point(make_solid(a), make_solid(b)), 0, false};
      EXPECT_NEAR(test::distance(point, b), 0, 1e-9) << "case " << i << " seed " << kSeed;
      EXPECT_NEAR(test::distance(a, point), truth, 1e-7) << "case " << i << " seed " << kSeed;
    } else {
      ASSERT_LE(g.lower, 1e-6) << "case " << i << " seed " << kSeed;
    }
  }
  std::printf("upper - lower at most %.2e mm\n", worst);
  EXPECT_LT(worst, 1e-8);
}

TEST(Gap, bodies_that_overlap_share_the_point) {
  test::RandomBodies random(kSeed);
  int overlapping = 0;
  for (int i = 0; i < 100000; ++i) {
    const bool grid = i % 2 == 0;
    const config::Body a = random.body(6, grid), b = random.body(6, grid);
    if (test::distance(a, b) > 0) continue;
    ++overlapping;
    const Vec3 at = nearest_point(make_solid(a), make_solid(b));
    const config::Body point{"point", {config::Shape::Kind::Box, {}}, at, 0, false};
    EXPECT_LE(test::distance(point, a), 1e-9) << "case " << i << " seed " << kSeed;
    EXPECT_LE(test::distance(point, b), 1e-9) << "case " << i << " seed " << kSeed;
  }
  EXPECT_GT(overlapping, 20000);
}

TEST(Gap, decides_a_sweep_as_the_closed_form_does) {
  test::RandomBodies random(kSeed);
  int free = 0, hit = 0, close_calls = 0;
  for (int i = 0; i < 40000; ++i) {
    const bool grid = i % 2 == 0;
    const config::Body a = random.body(14, grid), b = random.body(14, grid);
    const Vec3 d = random.step(30, grid);
    const double margin = grid ? 0.5 * random.whole(0, 4) : random.real(0, 3), truth = test::swept_distance(a, d, b);
    const Gap g = gap(make_solid(a), d, make_solid(b), margin);
    if (g.lower > margin) {
      ++free;
      ASSERT_GT(truth, margin - 1e-9) << "case " << i << " seed " << kSeed;
    } else {
      ++hit;
      close_calls += truth > margin;
      ASSERT_LT(truth, margin + 1e-7) << "case " << i << " seed " << kSeed;  // not needlessly refused either
    }
  }
  std::printf("%d free, %d hit, of which %d less than 0.1 nm from free\n", free, hit, close_calls);
  EXPECT_GT(free, 5000);
  EXPECT_GT(hit, 5000);
}

}  // namespace
}  // namespace gantry::motion
