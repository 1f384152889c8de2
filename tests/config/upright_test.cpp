// Boxes and cylinders that are in one another, against points that both hold.
#include "config/upright.hpp"

#include <algorithm>
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

/// Points on two surfaces are as near as a search over both finds them, and no nearer.
TEST(Upright, distances_are_those_of_the_nearest_points) {
  using Kind = Shape::Kind;
  const auto points = [](const Body& body) {
    std::vector<Vec3> out;
    constexpr int kSteps = 24;
    const Vec3 half = body.shape.size * 0.5;
    for (int i = 0; i <= kSteps; ++i)
      for (int k = 0; k <= kSteps; ++k) {
        const double u = 2.0 * i / kSteps - 1, v = 2.0 * k / kSteps - 1;
        if (body.shape.kind == Kind::Box) {
          const Vec2 along = rotated({u * half.x, half.y}, body.rotation_rad),
                     across = rotated({half.x, u * half.y}, body.rotation_rad),
                     face = rotated({u * half.x, v * half.y}, body.rotation_rad);
          for (const double side : {-1.0, 1.0}) {
            out.push_back(body.centre + Vec3{side * along.x, side * along.y, v * half.z});
            out.push_back(body.centre + Vec3{side * across.x, side * across.y, v * half.z});
            out.push_back(body.centre + Vec3{face.x, face.y, side * half.z});
          }
          continue;
        }
        const Vec2 round = rotated({1, 0}, M_PI * u), rim = round * half.x, disc = rim * ((v + 1) / 2);
        const bool capsule = body.shape.kind == Kind::Capsule;
        const double straight = capsule ? half.z - half.x : half.z;
        out.push_back(body.centre + Vec3{rim.x, rim.y, v * straight});
        const double dome = capsule ? std::sqrt(std::max(0.0, half.x * half.x - dot(disc, disc))) : 0;
        for (const double side : {-1.0, 1.0})
          out.push_back(body.centre + Vec3{disc.x, disc.y, side * (straight + dome)});
      }
    return out;
  };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(-12, 12), half(1, 4), turn(-3, 3);
  constexpr Kind kKinds[] = {Kind::Box, Kind::Cylinder, Kind::Capsule};
  int apart = 0;
  for (int round = 0; round < 90; ++round) {
    const auto body = [&](Kind kind) {
      Body b{.name = "b", .shape = {kind, {2 * half(random), 2 * half(random), 10}}, .centre = {}, .rotation_rad = 0};
      if (kind != Kind::Box) b.shape.size.y = b.shape.size.x;
      b.centre = {at(random), at(random), at(random)}, b.rotation_rad = turn(random);
      return b;
    };
    const Body a = body(kKinds[round % 3]), b = body(kKinds[round / 3 % 3]);
    const double found = distance_mm(a, b);
    EXPECT_NEAR(found, distance_mm(b, a), 1e-12);
    if (found == 0) continue;
    ++apart;
    std::vector<Vec3> of_a = points(a);
    const std::vector<Vec3> of_b = points(b);
    const auto from_b = [&](const Vec3& p) { return norm(p - b.centre); };
    std::ranges::sort(of_a, {}, from_b);
    double least = 1e9, reach = 0;
    for (const Vec3& q : of_b) reach = std::max(reach, from_b(q));
    for (const Vec3& p : of_a) {
      if (from_b(p) - reach > least) break;  // nothing of b is nearer to this one, nor to those that follow
      for (const Vec3& q : of_b) least = std::min(least, norm(p - q));
    }
    EXPECT_LE(found, least + 1e-9) << "round " << round;
    EXPECT_GE(found, least - 0.35) << "round " << round << ": the search's step";
  }
  EXPECT_GT(apart, 40);
}

}  // namespace
}  // namespace gantry::config
