#include "sim/world/solid_tree.hpp"

#include <gtest/gtest.h>
#include <random>

#include "sim/world/collisions.hpp"
#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

using Kind = config::Shape::Kind;

TEST(SolidTree, finds_what_a_look_at_every_box_finds) {
  constexpr unsigned kSeed = 11;
  std::mt19937_64 random(kSeed);
  // On a grid, so that many boxes touch, are alike, or are flat.
  const auto edge = [&] { return double(random() % 12); };
  const auto box = [&] {
    const Vec3 low{edge(), edge(), edge()};
    return Bounds{low, low + Vec3{double(random() % 4), double(random() % 4), double(random() % 4)}};
  };
  std::vector<std::uint32_t> found;
  SolidTree().meets(box(), found);
  EXPECT_TRUE(found.empty());
  for (int round = 0; round < 200; ++round) {
    std::vector<Bounds> all(1 + random() % 200);
    for (Bounds& b : all) b = box();
    const SolidTree tree(all);
    for (int question = 0; question < 50; ++question) {
      const Bounds asked = box();
      std::vector<std::uint32_t> judged;
      for (std::uint32_t i = 0; i < all.size(); ++i)
        if (asked.meets(all[i])) judged.push_back(i);
      tree.meets(asked, found);
      ASSERT_EQ(found, judged) << "seed " << kSeed << ", round " << round;
    }
  }
}

/// Judge: each solid has a watch of its own, which has nothing to leave out.
TEST(CollisionWatch, sees_among_many_solids_what_watches_of_one_solid_each_see) {
  constexpr unsigned kSeed = 12;
  constexpr int kScenes = 50, kPoses = 2000;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const config::Machine machine = sample::machine();
  const Head head(machine);
  std::size_t contacts = 0;
  for (int scene = 0; scene < kScenes; ++scene) {
    CollisionWatch watch(head);
    std::vector<Solid> solids;
    std::vector<CollisionWatch> alone;
    for (int i = 0; i < 60; ++i) {
      const Kind kind = std::array{Kind::Box, Kind::Cylinder, Kind::Capsule}[random() % 3];
      const double across = 2 + 10 * std::abs(unit(random));
      solids.push_back({"s" + std::to_string(i),
                        {kind, {across, kind == Kind::Box ? 8 : across, across + 20 * std::abs(unit(random))}},
                        {150 * unit(random), 150 * unit(random), -60 + 60 * unit(random)},
                        3 * unit(random),
                        i % 10 == 0 && kind == Kind::Box ? Vec2{0.02, -0.01} : Vec2{}});
      alone.emplace_back(head).set_solids({solids.back()});
    }
    watch.set_solids(solids);
    AxisVec at{};
    for (int pose = 0; pose < kPoses; ++pose) {
      AxisVec to = at;
      if (pose % 100 == 0)  // elsewhere
        for (std::size_t i = 0; i < 3; ++i) at[i] = to[i] = (i == 2 ? 40 : 150) * unit(random);
      for (std::size_t i = 0; i < 3; ++i) to[i] += unit(random);
      to[4] = 10 * std::abs(unit(random));
      std::vector<std::string> judged, seen;
      std::vector<std::vector<std::string>> of_body(head.bodies.size());
      for (CollisionWatch& one : alone)
        for (const Contact& c : one.step(at, to, 0.001))
          for (std::size_t body = 0; body < head.bodies.size(); ++body)
            if (head.bodies[body].name == c.moving)
              of_body[body].push_back(std::string(c.moving) + "/" + std::string(c.standing));
      for (const auto& of : of_body) judged.insert(judged.end(), of.begin(), of.end());
      for (const Contact& c : watch.step(at, to, 0.001))
        seen.push_back(std::string(c.moving) + "/" + std::string(c.standing));
      ASSERT_EQ(seen, judged) << "seed " << kSeed << ", scene " << scene << ", pose " << pose;
      contacts += seen.size();
      at = to;
    }
  }
  EXPECT_GT(contacts, 1000u);
}

}  // namespace
}  // namespace gantry::sim
