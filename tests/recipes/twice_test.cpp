// Deposits that lie on one another.
#include "recipes/twice.hpp"

#include <gtest/gtest.h>
#include <random>

namespace gantry::recipes {
namespace {

Feature dot(const std::string& id, Vec2 at, int line, const std::string& material = "glue", double height_mm = 0) {
  return Dot{id, at, material, {line, 1}, height_mm};
}
Feature bead(const std::string& id, std::vector<Vec3> points, int line, const std::string& material = "glue") {
  Bead b;
  b.id = id, b.points = std::move(points), b.material = material, b.location = {line, 1};
  return b;
}
std::vector<std::string> told(const std::vector<Feature>& features) {
  Recipe r;
  r.features = features;
  config::Mistakes mistakes("r.yaml");
  check_twice(r, mistakes);
  std::vector<std::string> out;
  for (const Error& e : mistakes.errors()) out.push_back(to_text(e));
  return out;
}

TEST(Twice, two_dots_of_one_material_on_one_spot_are_told_at_the_second) {
  const auto one = told({dot("a", {20, 20}, 9), dot("b", {20.05, 20}, 10)});
  ASSERT_EQ(one.size(), 1u);
  EXPECT_NE(one[0].find("r.yaml:10:1"), std::string::npos) << one[0];
  EXPECT_NE(one[0].find("dot 'b' lies on dot 'a' of line 9, 0.05 mm beside it"), std::string::npos) << one[0];
  EXPECT_TRUE(told({dot("a", {20, 20}, 9), dot("b", {20.11, 20}, 10)}).empty());
  EXPECT_TRUE(told({dot("a", {20, 20}, 9), dot("b", {20, 20}, 10, "sealant")}).empty()) << "one may lie on another";
  EXPECT_TRUE(told({dot("a", {20, 20}, 9), dot("b", {20, 20}, 10, "glue", 1)}).empty()) << "on top of it";
}

TEST(Twice, a_bead_along_another_is_told_in_either_direction) {
  const std::vector<Vec3> there{{20, 20, 0}, {40, 20, 0}, {40, 30, 0}}, back(there.rbegin(), there.rend());
  EXPECT_EQ(told({bead("a", there, 9), bead("b", there, 10)}).size(), 1u);
  EXPECT_EQ(told({bead("a", there, 9), bead("b", back, 10)}).size(), 1u);
  EXPECT_TRUE(told({bead("a", there, 9), bead("b", back, 10, "sealant")}).empty());
  EXPECT_TRUE(told({bead("a", there, 9), bead("b", {{20, 20, 0}, {40, 20.2, 0}, {40, 30, 0}}, 10)}).empty());
  EXPECT_TRUE(told({bead("a", there, 9), dot("b", {20, 20}, 10)}).empty()) << "a dot at a bead's end";
}

/// Every pair is compared by brute force, at distances about the limit and across the borders of every cell.
TEST(Twice, agrees_with_a_comparison_of_all_pairs) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> at(0, 3), near(-0.12, 0.12);
  int twice = 0;
  for (int round = 0; round < 2000; ++round) {
    const Vec2 first{at(random), at(random)}, second{first.x + near(random), first.y + near(random)};
    const bool same = norm(first - second) < kSameSpot_mm;
    twice += same;
    EXPECT_EQ(told({dot("a", first, 1), dot("far", {first.x + 1, first.y}, 2), dot("b", second, 3)}).size(), same)
        << "seed " << kSeed << " round " << round;
    const std::vector<Vec3> one{{first.x, first.y, 0}, {9, 9, 0}}, other{{9, 9, 0}, {second.x, second.y, 0}};
    EXPECT_EQ(told({bead("a", one, 1), bead("b", other, 2)}).size(), same) << "seed " << kSeed << " round " << round;
  }
  EXPECT_GT(twice, 500);
}

TEST(Twice, an_array_over_another_is_told_once) {
  std::vector<Feature> all;
  for (int line : {1, 2})
    for (int i = 0; i < 100; ++i) all.push_back(dot("d", {i * 0.5, 0}, line));
  EXPECT_EQ(told(all).size(), 1u);
}

TEST(Twice, what_a_purge_would_hit_is_found_seen_from_above) {
  Recipe r;
  r.features = {dot("a", {20, 20}, 1), bead("b", {{30, 10, 0}, {50, 10, 5}}, 2)};
  const auto hit = [&](Vec2 at) {
    const Feature* f = feature_near(r, at, kPurgeClear_mm);
    return f == nullptr ? std::string("nothing") : id_of(*f);
  };
  EXPECT_EQ(hit({20, 20.9}), "a");
  EXPECT_EQ(hit({20, 21.1}), "nothing");
  EXPECT_EQ(hit({40, 10.9}), "b");
  EXPECT_EQ(hit({51.1, 10}), "nothing");
}

}  // namespace
}  // namespace gantry::recipes
