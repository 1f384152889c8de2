#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "recipes/recipe.hpp"

namespace gantry::recipes {
namespace {

double distance(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 leg = b - a;
  const double t = std::clamp(dot(p - a, leg) / dot(leg, leg), 0.0, 1.0);
  return norm(p - (a + leg * t));
}

/// The points that a path back passes by: the bead's from its end, and the one where the path ends.
std::vector<Vec3> passed(const Bead& bead, double back_mm) {
  std::vector<Vec3> out{bead.points.back()};
  for (std::size_t i = bead.points.size() - 1; i > 0 && back_mm > 0; --i) {
    const Vec3 leg = bead.points[i - 1] - bead.points[i];
    if (norm(leg) <= 0) continue;
    out.push_back(bead.points[i] + leg * std::min(1.0, back_mm / norm(leg)));
    back_mm -= norm(leg);
  }
  return out;
}

/// By brute force: each leg as long as what it leaves out allows, every point of it looked at for each end.
std::size_t longest_legs(const std::vector<Vec3>& all, double off_mm) {
  std::size_t legs = 0;
  for (std::size_t from = 0; from + 1 < all.size(); ++legs) {
    std::size_t to = from + 1;
    const auto fits = [&](std::size_t end) {
      for (std::size_t i = from + 1; i < end; ++i)
        if (distance(all[i], all[from], all[end]) > off_mm) return false;
      return true;
    };
    while (to + 1 < all.size() && fits(to + 1)) ++to;
    from = to;
  }
  return legs;
}

/// Every leg ends at a point of the bead, and is as near to those that it leaves out as allowed. How many legs.
std::size_t expect_near(const Bead& bead, double back_mm, double off_mm) {
  const std::vector<Vec3> all = passed(bead, back_mm);
  const Retrace back = retrace(bead, back_mm, off_mm);
  EXPECT_EQ(back.points.front(), all.front());
  EXPECT_EQ(back.points.back(), all.back());
  std::size_t at = 0;
  for (std::size_t leg = 1; leg < back.points.size(); ++leg) {
    const std::size_t from = at;
    while (++at < all.size() && all[at] != back.points[leg]) {
    }
    if (at >= all.size()) {
      ADD_FAILURE() << "leg " << leg << " ends beside the bead";
      return 0;
    }
    for (std::size_t i = from + 1; i < at; ++i)
      EXPECT_LE(distance(all[i], all[from], all[at]), off_mm * (1 + 1e-9)) << "leg " << leg << ", point " << i;
  }
  return back.points.size() - 1;
}

Bead bead_of(std::vector<Vec3> points) {
  Bead bead;
  bead.points = std::move(points);
  return bead;
}

TEST(Retrace, costs_one_look_at_each_point_however_long_its_legs_are) {
  constexpr std::size_t kPoints = 90000;
  std::vector<Vec3> line, wave;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double x = 1e-3 * static_cast<double>(i);
    line.push_back({x, 2 * x, 0});
    wave.push_back({x, 0.02 * std::sin(x * 40), 0.01 * std::cos(x * 7)});
  }
  for (const auto& points : {line, wave}) {
    const Retrace back = retrace(bead_of(points), 1000, 0.05);
    EXPECT_LE(back.looks, kPoints);
    EXPECT_EQ(back.points.size(), 2u) << "one leg over all of them";
    EXPECT_EQ(back.points.back(), points.front());
  }
}

TEST(Retrace, has_the_legs_of_the_brute_force_on_smooth_beads) {
  for (const double radius : {0.5, 3.0, 40.0})
    for (const double off_mm : {0.05, 0.2}) {
      std::vector<Vec3> arc, helix;
      for (int i = 0; i <= 400; ++i) {
        const double t = 0.01 * i;
        arc.push_back({radius * std::cos(t), radius * std::sin(t), 0});
        helix.push_back({radius * std::cos(t), radius * std::sin(t), 0.3 * radius * t});
      }
      for (const double back_mm : {2.0, 100.0}) {
        EXPECT_EQ(expect_near(bead_of(arc), back_mm, off_mm), longest_legs(passed(bead_of(arc), back_mm), off_mm));
        const std::size_t least = longest_legs(passed(bead_of(helix), back_mm), off_mm);
        EXPECT_LE(expect_near(bead_of(helix), back_mm, off_mm), least + least / 3 + 1);
      }
    }
}

TEST(Retrace, is_near_to_what_it_leaves_out_on_any_bead) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 2000; ++round) {
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", round " << round);
    const auto draw = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
    const double step_mm = std::pow(10, draw(-3, 1)), off_mm = std::pow(10, draw(-2, 0)), bend = draw(0, 1.5);
    std::vector<Vec3> points{{0, 0, 0}};
    double heading = 0;
    for (int i = 0; i < 60; ++i) {
      heading += draw(-bend, bend);
      const double length = draw(0, 1) < 0.1 ? 0 : step_mm * draw(0.1, 1);
      points.push_back(points.back() + Vec3{length * std::cos(heading), length * std::sin(heading),
                                            draw(0, 1) < 0.3 ? length * draw(-0.5, 0.5) : 0});
    }
    expect_near(bead_of(points), draw(0, 100) * step_mm, off_mm);
  }
}

}  // namespace
}  // namespace gantry::recipes
