// FCL as a foreign judge: no motion that the sweep calls free collides at any of its sampled poses. Only FCL's boolean
// collide() and only mm are used: its box-box distance is too large on a common grid, and its continuous check misses
// hits.
#include <fcl/narrowphase/collision.h>
#include <gtest/gtest.h>

#include "motion/plan/gap.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

constexpr std::uint64_t kSeed = 31337;

fcl::CollisionObjectd object(const config::Body& b) {
  const Vec3 s = b.shape.size;
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  switch (b.shape.kind) {
    case config::Shape::Kind::Box: geometry = std::make_shared<fcl::Boxd>(s.x, s.y, s.z); break;
    case config::Shape::Kind::Cylinder: geometry = std::make_shared<fcl::Cylinderd>(s.x / 2, s.z); break;
    case config::Shape::Kind::Capsule:
      geometry = std::make_shared<fcl::Capsuled>(s.x / 2, std::max(0.0, s.z - s.x));
      break;
  }
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.rotate(fcl::AngleAxisd(b.rotation_rad, fcl::Vector3d::UnitZ()));
  pose.translation() = fcl::Vector3d(b.centre.x, b.centre.y, b.centre.z);
  return {geometry, pose};
}
bool collide(const fcl::CollisionObjectd& a, const fcl::CollisionObjectd& b) {
  fcl::CollisionResultd result;
  return fcl::collide(&a, &b, fcl::CollisionRequestd(), result) > 0;
}

TEST(Sweep, is_never_free_where_fcl_finds_a_colliding_pose) {
  test::RandomBodies random(kSeed);
  int free = 0, hit = 0, hits_seen = 0;
  for (int i = 0; i < 8000; ++i) {
    const bool grid = i % 2 == 0;
    const config::Body a = random.body(12, grid), b = random.body(12, grid);
    const Vec3 d = random.step(30, grid);
    constexpr double kMargin = 0.001;  // faces that touch are nobody's to decide
    const bool is_free = gap(make_solid(a), d, make_solid(b), kMargin).lower > kMargin;
    fcl::CollisionObjectd moving = object(a);
    const fcl::CollisionObjectd standing = object(b);
    const fcl::Vector3d start = moving.getTranslation();
    bool seen = false;
    for (int k = 0; k <= 100 && !seen; ++k) {
      moving.setTranslation(start + fcl::Vector3d(d.x, d.y, d.z) * (k / 100.0));
      seen = collide(moving, standing);
    }
    ASSERT_FALSE(is_free && seen) << "case " << i << " seed " << kSeed;
    ++(is_free ? free : hit);
    hits_seen += seen;
  }
  std::printf("%d free, none contradicted; %d hits, of which FCL's samples see %d\n", free, hit, hits_seen);
  EXPECT_GT(free, 1000);
  EXPECT_GT(hits_seen, 1000);
}

}  // namespace
}  // namespace gantry::motion
