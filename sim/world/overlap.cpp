#include "sim/world/overlap.hpp"

#include <cmath>
#include <fcl/narrowphase/collision.h>

namespace gantry::sim {

struct OverlapShape::Geometry {
  std::unique_ptr<fcl::CollisionGeometryd> shape;
};

namespace {

std::unique_ptr<fcl::CollisionGeometryd> made(const config::Shape& shape) {
  const Vec3& s = shape.size;
  switch (shape.kind) {
    case config::Shape::Kind::Cylinder: return std::make_unique<fcl::Cylinderd>(s.x / 2, s.z);
    case config::Shape::Kind::Capsule: return std::make_unique<fcl::Capsuled>(s.x / 2, std::max(s.z - s.x, 1e-6));
    case config::Shape::Kind::Box: break;
  }
  return std::make_unique<fcl::Boxd>(s.x, s.y, s.z);
}

fcl::Transform3d pose(const Solid& solid) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  fcl::Matrix3d turn = Eigen::AngleAxisd(solid.rotation_rad, fcl::Vector3d::UnitZ()).toRotationMatrix();
  if (solid.slope.x != 0 || solid.slope.y != 0) {
    const fcl::Vector3d x = fcl::Vector3d(1, 0, solid.slope.x).normalized();
    const fcl::Vector3d z = fcl::Vector3d(-solid.slope.x, -solid.slope.y, 1).normalized();
    fcl::Matrix3d tilt;
    tilt << x, z.cross(x), z;
    turn = turn * tilt;
  }
  out.linear() = turn;
  out.translation() = fcl::Vector3d(solid.centre.x, solid.centre.y, solid.centre.z);
  return out;
}

}  // namespace

OverlapShape::OverlapShape(const config::Shape& shape) : geometry_(std::make_unique<Geometry>(Geometry{made(shape)})) {}
OverlapShape::~OverlapShape() = default;
OverlapShape::OverlapShape(OverlapShape&&) noexcept = default;
OverlapShape& OverlapShape::operator=(OverlapShape&&) noexcept = default;

bool overlap(const OverlapShape& a, const Solid& at_a, const OverlapShape& b, const Solid& at_b) {
  const fcl::CollisionRequestd request(1, false);
  fcl::CollisionResultd result;
  return fcl::collide(a.geometry_->shape.get(), pose(at_a), b.geometry_->shape.get(), pose(at_b), request, result) > 0;
}

}  // namespace gantry::sim
