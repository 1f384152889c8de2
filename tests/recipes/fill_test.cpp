#include "recipes/fill.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace gantry::recipes {
namespace {

using Polygon = std::vector<Vec2>;
constexpr std::size_t kMany = 100000;

double distance_to_edges(Vec2 p, const Polygon& outline) {
  double best = 1e9;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Vec2 a = outline[k], leg = outline[(k + 1) % outline.size()] - a;
    const double t = std::clamp(dot(p - a, leg) / dot(leg, leg), 0.0, 1.0);
    best = std::min(best, norm(p - (a + leg * t)));
  }
  return best;
}

/// By the angle that the outline turns about the point, another way than the code's.
bool within(Vec2 p, const Polygon& outline) {
  double turned = 0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Vec2 a = outline[k] - p, b = outline[(k + 1) % outline.size()] - p;
    turned += std::atan2(a.x * b.y - a.y * b.x, dot(a, b));
  }
  return std::abs(turned) > 3;
}

double distance_to_runs(Vec2 p, const FilledArea& filled) {
  double best = 1e9;
  for (const auto& run : filled.runs)
    for (std::size_t i = 1; i < run.size(); ++i) {
      const Vec2 leg = run[i] - run[i - 1];
      const double t = std::clamp(dot(p - run[i - 1], leg) / dot(leg, leg), 0.0, 1.0);
      best = std::min(best, norm(p - (run[i - 1] + leg * t)));
    }
  return best;
}

/// The path keeps half a spacing from the outline, its lines are parallel and a spacing apart, and nothing that is a
/// spacing within the outline stays uncovered.
void expect_covered(const Polygon& outline, const FilledArea& filled, const FillLines& lines, std::mt19937& random,
                    const std::string& what) {
  const double half = lines.spacing_mm / 2;
  for (const auto& run : filled.runs) {
    ASSERT_GE(run.size(), 2u);
    for (std::size_t i = 1; i < run.size(); ++i) {
      const Vec2 leg = rotated(run[i] - run[i - 1], -lines.angle_rad);
      if (i % 2 == 1)
        EXPECT_NEAR(leg.y, 0, 1e-9) << what << ": a line";
      else
        EXPECT_NEAR(leg.y, lines.spacing_mm, 1e-9) << what << ": from line to line";
      for (int k = 0; k <= 10; ++k) {
        const Vec2 p = run[i - 1] + (run[i] - run[i - 1]) * (k / 10.0);
        EXPECT_TRUE(within(p, outline)) << what;
        EXPECT_GE(distance_to_edges(p, outline), half * (1 - 1e-5)) << what;
      }
    }
  }
  double x0 = 1e9, x1 = -1e9, y0 = 1e9, y1 = -1e9;
  for (const Vec2 p : outline)
    x0 = std::min(x0, p.x), x1 = std::max(x1, p.x), y0 = std::min(y0, p.y), y1 = std::max(y1, p.y);
  std::uniform_real_distribution<double> x(x0, x1), y(y0, y1);
  for (int n = 0; n < 400; ++n) {
    const Vec2 p{x(random), y(random)};
    if (!within(p, outline) || distance_to_edges(p, outline) < lines.spacing_mm + 0.02) continue;
    EXPECT_LE(distance_to_runs(p, filled), half + 1e-6) << what << ": uncovered at " << p.x << ", " << p.y;
  }
  for (int n = 0; n < 400; ++n) {
    const Vec2 p{x(random), y(random)};
    if (!within(p, outline)) continue;
    EXPECT_LE(distance_to_runs(p, filled), std::max(filled.bare.farthest_mm, half * M_SQRT2) + half) << what;
  }
}

TEST(Fill, of_a_rectangle_is_what_one_draws_by_hand) {
  const auto filled = fill_area({{0, 0}, {20, 0}, {20, 6}, {0, 6}}, {2, 0, true}, kMany);
  ASSERT_TRUE(filled) << filled.error().message;
  const std::vector<Vec2> want{{1, 1}, {19, 1}, {19, 3}, {1, 3}, {1, 5}, {19, 5}};
  ASSERT_EQ(filled->runs.size(), 1u);
  ASSERT_EQ(filled->runs[0].size(), want.size());
  for (std::size_t i = 0; i < want.size(); ++i) EXPECT_LT(norm(filled->runs[0][i] - want[i]), 1e-6) << i;
  EXPECT_NEAR(filled->area_mm2, 120, 1e-9);
}

TEST(Fill, shares_what_is_left_over_by_both_sides_and_may_run_one_way_only) {
  const auto filled = fill_area({{0, 0}, {20, 0}, {20, 7}, {0, 7}}, {2, 0, false}, kMany);
  ASSERT_TRUE(filled);
  ASSERT_EQ(filled->runs.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LT(norm(filled->runs[k][0] - Vec2{1, 1.5 + 2 * static_cast<double>(k)}), 1e-6);
    EXPECT_LT(norm(filled->runs[k][1] - Vec2{19, 1.5 + 2 * static_cast<double>(k)}), 1e-6);
  }
}

TEST(Fill, covers_random_convex_and_star_shaped_areas) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int n = 0; n < 60; ++n) {
    Polygon outline;
    const int corners = 3 + static_cast<int>(unit(random) * 9);
    const bool star = n % 2 == 1;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * M_PI * (k + 0.6 * unit(random)) / corners, r = star ? 6 + 20 * unit(random) : 22;
      outline.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    if (n % 3 == 0) std::reverse(outline.begin(), outline.end());
    const FillLines lines{0.6 + 2 * unit(random), 6 * unit(random) - 3, n % 5 != 0};
    const auto filled = fill_area(outline, lines, kMany);
    const std::string what = "seed 11, case " + std::to_string(n);
    ASSERT_TRUE(filled) << what << ": " << filled.error().message;
    expect_covered(outline, *filled, lines, random, what);
    if (!star && lines.serpentine) {
      EXPECT_EQ(filled->runs.size(), 1u) << what << ": a convex area is one run";
    }
    // Monte Carlo: the share of a square that is inside.
    int hits = 0;
    for (int k = 0; k < 4000; ++k) hits += within({56 * unit(random) - 28, 56 * unit(random) - 28}, outline);
    EXPECT_NEAR(filled->area_mm2, 56 * 56 * hits / 4000.0, 130) << what;
  }
}

TEST(Fill, of_a_comb_goes_up_each_tooth) {
  const Polygon comb{{0, 0},   {50, 0},  {50, 30}, {40, 30}, {40, 10}, {30, 10},
                     {30, 30}, {20, 30}, {20, 10}, {10, 10}, {10, 30}, {0, 30}};
  std::mt19937 random(1);
  for (const double angle : {0.0, 0.4, M_PI / 2}) {
    const FillLines lines{2, angle, true};
    const auto filled = fill_area(comb, lines, kMany);
    ASSERT_TRUE(filled) << filled.error().message;
    EXPECT_GE(filled->runs.size(), angle == 0 ? 3u : 1u);
    EXPECT_NEAR(filled->area_mm2, 50 * 10 + 3 * 10 * 20, 1e-9);
    expect_covered(comb, *filled, lines, random, "comb");
  }
}

// A square of 10 and an arm of 10 x 1.5, into which no line of a spacing of 2 fits: the lowest, at 1 mm, keeps 1 mm
// from the arm's corner at (10, 1.5), so ends at 10 - sqrt(1 - 0.25) and covers 1 mm more. The rest of the arm is bare.
TEST(Fill, tells_what_it_leaves_bare) {
  const Polygon l{{0, 0}, {20, 0}, {20, 1.5}, {10, 1.5}, {10, 10}, {0, 10}};
  const double covered = 11 - std::sqrt(0.75), share = (20 - covered) * 1.5 / 115;
  for (const double turned : {0.0, 0.5, -2.0}) {
    Polygon outline;
    for (const Vec2 p : l) outline.push_back(rotated(p, turned));
    const auto filled = fill_area(outline, {2, turned, true}, kMany);
    ASSERT_TRUE(filled);
    EXPECT_NEAR(filled->bare.share, share, 1e-6);
    EXPECT_NEAR(filled->bare.farthest_mm, std::hypot(20 - covered + 1, 0.75), 1e-6) << "looked for at y = 0.25";
    EXPECT_LT(norm(filled->bare.at - rotated({20, 0.25}, turned)), 1e-6);
  }
  // 7 mm hold three strips of 2 mm: half a millimetre on both sides, which is no farther than its corners are.
  const auto left_over = fill_area({{0, 0}, {20, 0}, {20, 7}, {0, 7}}, {2, 0, true}, kMany);
  EXPECT_NEAR(left_over->bare.share, 1.0 / 7, 1e-6);
  EXPECT_LE(left_over->bare.farthest_mm, std::hypot(1, 1.5));
  EXPECT_NEAR(fill_area({{0, 0}, {20, 0}, {20, 6}, {0, 6}}, {2, 0, true}, kMany)->bare.share, 0, 1e-6);
}

TEST(Fill, that_cannot_be_meant_says_why) {
  const auto says = [](const Polygon& outline, FillLines lines, Fault fault, const char* words) {
    const auto filled = fill_area(outline, lines, 1000);
    ASSERT_FALSE(filled) << words;
    EXPECT_EQ(filled.error().fault, fault);
    EXPECT_NE(filled.error().message.find(words), std::string::npos) << filled.error().message;
  };
  const Polygon square{{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  says(square, {11, 0, true}, Fault::Inconsistent, "less than their spacing");
  says({{0, 0}, {10, 10}, {10, 0}, {0, 10}}, {1, 0, true}, Fault::Inconsistent, "crosses itself");
  says({{0, 0}, {10, 0}, {10, 10}, {5, 0}, {0, 10}}, {1, 0, true}, Fault::Inconsistent, "crosses itself");
  says({{0, 0}, {10, 0}, {5, 0}, {5, 10}}, {1, 0, true}, Fault::Inconsistent, "back on itself");
  says({{0, 0}, {10, 0}, {10, 0}, {5, 10}}, {1, 0, true}, Fault::Inconsistent, "same point");
  says({{0, 0}, {10, 0}, {5, 0}}, {1, 0, true}, Fault::Inconsistent, "back on itself");
  says({{0, 0}, {10, 0}}, {1, 0, true}, Fault::Inconsistent, "three corners");
  says({{0, 0}, {10, 0}, {10, 0.5}, {0, 0.5}}, {1, M_PI / 2, true}, Fault::Inconsistent, "nowhere as wide");
  says(square, {0.01, 0, true}, Fault::TooManySteps, "'spacing'");
}

}  // namespace
}  // namespace gantry::recipes
