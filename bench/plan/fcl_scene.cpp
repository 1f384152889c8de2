#include "bench/plan/fcl_scene.hpp"

#include <algorithm>
#include <cmath>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <vector>

namespace gantry::bench {
namespace {

fcl::CollisionObjectd* object(const config::Body& b) {
  const Vec3 s = b.shape.size;
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  switch (b.shape.kind) {
    case config::Shape::Kind::Box: geometry = std::make_shared<fcl::Boxd>(s.x, s.y, s.z); break;
    case config::Shape::Kind::Cylinder: geometry = std::make_shared<fcl::Cylinderd>(s.x / 2, s.z); break;
    case config::Shape::Kind::Capsule: geometry = std::make_shared<fcl::Capsuled>(s.x / 2, s.z - s.x); break;
  }
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.rotate(fcl::AngleAxisd(b.rotation_rad, fcl::Vector3d::UnitZ()));
  pose.translation() = fcl::Vector3d(b.centre.x, b.centre.y, b.centre.z);
  auto* out = new fcl::CollisionObjectd(geometry, pose);
  out->computeAABB();
  return out;
}

bool meet(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* found) {
  fcl::CollisionResultd result;
  *static_cast<bool*>(found) = fcl::collide(a, b, fcl::CollisionRequestd(), result) > 0;
  return *static_cast<bool*>(found);  // true ends the walk
}

}  // namespace

struct FclScene::Parts {
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> head, standing;
  std::vector<Vec3> home;  ///< of head, with the tip at 0
  fcl::DynamicAABBTreeCollisionManagerd tree;
};

FclScene::FclScene(const config::Machine& machine) : parts_(std::make_unique<Parts>()) {
  for (const config::Body& b : machine.head) {
    parts_->head.emplace_back(object(b));
    parts_->home.push_back(b.centre);
  }
  for (const config::Body& b : machine.scene) {
    parts_->standing.emplace_back(object(b));
    parts_->tree.registerObject(parts_->standing.back().get());
  }
  parts_->tree.setup();
}
FclScene::~FclScene() = default;

bool FclScene::collides(Vec3 tip) {
  for (std::size_t i = 0; i < parts_->head.size(); ++i) {
    fcl::CollisionObjectd& body = *parts_->head[i];
    const Vec3 at = parts_->home[i] + tip;
    body.setTranslation(fcl::Vector3d(at.x, at.y, at.z));
    body.computeAABB();
    bool found = false;
    ++calls_;
    parts_->tree.collide(&body, &found, meet);
    if (found) return true;
  }
  return false;
}

bool FclScene::line_is_free(Vec3 from, Vec3 to, double step_mm) {
  const int steps = std::max(1, static_cast<int>(std::ceil(norm(to - from) / step_mm)));
  for (int i = 0; i <= steps; ++i)
    if (collides(from + (to - from) * (1.0 * i / steps))) return false;
  return true;
}

}  // namespace gantry::bench
