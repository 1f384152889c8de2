#include "app/record/tip_lines.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace gantry::record {
namespace {

double off(Vec3 p, const std::vector<Vec3>& line) {
  double least = norm(p - line.front());
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vec3 d = line[i + 1] - line[i];
    const double length = norm(d);
    const double s = length > 0 ? std::min(std::max(dot(p - line[i], d) / length, 0.0), length) : 0;
    least = std::min(least, norm(p - line[i] - (length > 0 ? d * (s / length) : Vec3{})));
  }
  return least;
}

TEST(TipLines, no_point_is_farther_from_the_line_than_the_tolerance) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    std::mt19937 random(seed);
    std::normal_distribution<double> step(0, 0.3);
    std::vector<Vec3> walk{{0, 0, 0}};
    while (walk.size() < 3000)
      walk.push_back(walk.back() + Vec3{step(random), step(random), walk.size() % 400 < 200 ? 0 : step(random)});
    for (const double tolerance : {0.01, 0.5, 5.0}) {
      const auto kept = simplified(walk, tolerance);
      EXPECT_EQ(kept.front(), walk.front());
      EXPECT_EQ(kept.back(), walk.back());
      for (std::size_t i = 0; i < walk.size(); i += 7)
        ASSERT_LE(off(walk[i], kept), tolerance * (1 + 1e-9)) << "seed " << seed << ", point " << i;
    }
    EXPECT_LT(simplified(walk, 5).size(), walk.size() / 10) << "seed " << seed;
  }
}

TEST(TipLines, points_on_a_line_and_too_few_points) {
  std::vector<Vec3> straight;
  for (int i = 0; i <= 100; ++i) straight.push_back({i * 1.0, 0, 0});
  EXPECT_EQ(simplified(straight, 0.01).size(), 2u);
  EXPECT_TRUE(simplified({}, 1).empty());
  EXPECT_EQ(simplified(std::vector<Vec3>{{1, 2, 3}}, 1).size(), 1u);
  EXPECT_EQ(simplified(std::vector<Vec3>(50, Vec3{1, 2, 3}), 1).size(), 2u) << "standing still";
}

/// Block 1 goes about without the valve; block 2 sets a dot and lays a bead.
TEST(TipLines, each_block_is_a_line_and_the_valve_makes_dots_and_beads) {
  JobResult r;
  r.drawing.tip_of_block = {{}, {0, 0, -10}, {0, 0, -40}};
  const auto go = [&](Vec3 head, std::uint32_t block, bool valve) {
    r.actual.push_back(
        {.t_s = 0.01 * static_cast<double>(r.actual.size()), .head = head, .block = block, .valve = valve});
  };
  go({0, 0, 50}, 1, false), go({5, 0, 50}, 1, false);
  go({5, 0, 50}, 2, false), go({9, 0, 50}, 2, true), go({9, 0.01, 50}, 2, true), go({9, 0, 50}, 2, false);
  go({20, 0, 50}, 2, true), go({20, 8, 50}, 2, true), go({26, 8, 50}, 2, true), go({26, 8, 60}, 2, false);
  go({std::numeric_limits<double>::quiet_NaN(), 8, 60}, 2, false);
  const auto lines = tip_lines(r);
  ASSERT_EQ(lines.travel.size(), 2u);
  EXPECT_EQ(lines.travel[0], (std::vector<Vec3>{{0, 0, 40}, {5, 0, 40}}));
  EXPECT_EQ(lines.travel[1].back(), (Vec3{26, 8, 20}));
  EXPECT_EQ(lines.dots, (std::vector<Vec3>{{9, 0, 10}}));
  ASSERT_EQ(lines.beads.size(), 1u);
  EXPECT_EQ(lines.beads[0], (std::vector<Vec3>{{20, 0, 10}, {20, 8, 10}, {26, 8, 10}}));
  EXPECT_EQ(lines.within_mm, 0.01);

  r.planned = std::exchange(r.actual, {});
  EXPECT_EQ(tip_lines(r).dots.size(), 1u) << "what was planned, where nothing has moved";
}

TEST(TipLines, a_hundred_thousand_dots_and_a_million_turns_are_bounded_and_the_bound_is_told) {
  JobResult r;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> hop(1, 4);
  for (int i = 0; i < 100'000; ++i) {
    const Vec3 at{(i % 400) * 0.5, (i / 400) * 0.5, 0};
    const Vec3 up{0, 0, hop(random)};
    r.actual.push_back({.t_s = 0, .head = at + up, .block = 1});
    r.actual.push_back({.t_s = 0, .head = at, .block = 1, .valve = true});
    r.actual.push_back({.t_s = 0, .head = at + up, .block = 1});
  }
  const auto lines = tip_lines(r);
  ASSERT_EQ(lines.travel.size(), 1u);
  EXPECT_LE(lines.travel[0].size(), 20000u);
  EXPECT_EQ(lines.every_dot, 10u);
  EXPECT_EQ(lines.dots.size(), 10000u);
  EXPECT_GT(lines.within_mm, 0.01);
  for (std::size_t i = 0; i < r.actual.size(); i += 9973)
    EXPECT_LE(off(r.actual[i].head, lines.travel[0]), lines.within_mm * (1 + 1e-9));

  for (int i = 0; i < 9000; ++i) r.drawing.asked.push_back({{0, i * 1.0, 0}, {5, i * 1.0, 0}});
  const auto asked = asked_lines(r);
  EXPECT_EQ(asked.every_bead, 3u);
  EXPECT_EQ(asked.beads.size(), 3000u);
}

}  // namespace
}  // namespace gantry::record
