#include "motion/plan/second_opinion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <exception>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <vector>

#include "motion/geometry.hpp"
#include "motion/plan/gap.hpp"

namespace gantry::motion {
namespace {

using fcl::CollisionObjectd;

/// So many poses are looked at together: what their common box does not touch is not near any of them.
constexpr std::size_t kTogether = 32;
/// Scenes that are kept: of travels and touches, before and after the board was measured.
constexpr std::size_t kScenes = 4;

/// FCL has no use for what has no size.
double some(double half) {
  constexpr double kLeast_mm = 1e-6;
  return std::max(half, kLeast_mm);
}

fcl::Matrix3d rotation(const Solid& s) {
  fcl::Matrix3d out;
  out << s.cos, -s.sin, 0, s.sin, s.cos, 0, 0, 0, 1;
  return out;
}

std::unique_ptr<CollisionObjectd> object(const Solid& s) {
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  switch (s.kind) {
    case Solid::Kind::Box:
      geometry = std::make_shared<fcl::Boxd>(2 * some(s.half.x), 2 * some(s.half.y), 2 * some(s.half.z));
      break;
    case Solid::Kind::Cylinder: geometry = std::make_shared<fcl::Cylinderd>(some(s.half.x), 2 * some(s.half.z)); break;
    case Solid::Kind::Capsule:
      if (s.half.z > 0)
        geometry = std::make_shared<fcl::Capsuled>(some(s.half.x), 2 * s.half.z);
      else
        geometry = std::make_shared<fcl::Sphered>(some(s.half.x));
      break;
  }
  fcl::Transform3d pose = fcl::Transform3d::Identity();
  pose.linear() = rotation(s);
  pose.translation() = fcl::Vector3d(s.centre.x, s.centre.y, s.centre.z);
  auto out = std::make_unique<CollisionObjectd>(geometry, pose);
  out->computeAABB();
  return out;
}

fcl::Vector3d vector(Vec3 v) { return {v.x, v.y, v.z}; }

/// What of the tree is near a box: callback of FCL's broad phase.
struct Near {
  const CollisionObjectd* box = nullptr;
  std::vector<CollisionObjectd*>* found = nullptr;
};
bool collect(CollisionObjectd* a, CollisionObjectd* b, void* data) {
  const Near& near = *static_cast<Near*>(data);
  near.found->push_back(a == near.box ? b : a);
  return false;  // goes on
}

/// A scene as FCL has it.
class FclScene {
 public:
  explicit FclScene(const Scene& scene) : hash_(scene.hash()) {
    for (const SceneBody& body : scene.head()) {
      head_.push_back(object(body.solid));
    }
    std::vector<CollisionObjectd*> all;
    for (std::size_t i = 0; i < scene.standing().size(); ++i) {
      standing_.push_back(object(scene.standing()[i].solid));
      standing_.back()->setUserData(reinterpret_cast<void*>(static_cast<std::uintptr_t>(i)));
      all.push_back(standing_.back().get());
    }
    tree_.registerObjects(all);
    tree_.setup();
  }

  [[nodiscard]] bool is_of(const Scene& scene) const {
    return hash_ == scene.hash() && head_.size() == scene.head().size() && standing_.size() == scene.standing().size();
  }

  struct Contact {
    std::size_t head = 0, standing = 0, pose = 0;
  };
  /// The first pair that is asked for and meets at one of the poses.
  std::optional<Contact> contact(const Scene& scene, const Margins& margins, std::span<const AxisVec> poses) {
    for (std::size_t i = 0; i < head_.size(); ++i) {
      CollisionObjectd& body = *head_[i];
      const auto go_to = [&](const AxisVec& q) {
        const Solid there = scene.placed(scene.head()[i], q);
        body.setTranslation(vector(there.centre));
        if (scene.head()[i].turning_mm > 0) body.setRotation(rotation(there));
        body.computeAABB();
      };
      go_to(poses.front());
      fcl::AABBd swept = body.getAABB();
      for (const AxisVec& q : poses.subspan(1)) go_to(q), swept += body.getAABB();
      for (CollisionObjectd* other : near(swept)) {
        const auto standing = static_cast<std::size_t>(reinterpret_cast<std::uintptr_t>(other->getUserData()));
        if (is_let_near(margins, i, standing)) continue;
        for (std::size_t k = 0; k < poses.size(); ++k) {
          go_to(poses[k]);
          if (body.getAABB().overlap(other->getAABB()) && meet(body, *other)) return Contact{i, standing, k};
        }
      }
    }
    return std::nullopt;
  }

 private:
  static bool is_let_near(const Margins& margins, std::size_t head, std::size_t standing) {
    return std::any_of(margins.pairs.begin(), margins.pairs.end(),
                       [&](const PairMargin& pair) { return pair.head == head && pair.standing == standing; });
  }

  static bool meet(const CollisionObjectd& a, const CollisionObjectd& b) {
    fcl::CollisionResultd result;
    return fcl::collide(&a, &b, fcl::CollisionRequestd(1, false), result) > 0;
  }

  const std::vector<CollisionObjectd*>& near(const fcl::AABBd& box) {
    found_.clear();
    if (tree_.empty()) return found_;
    const fcl::Vector3d edges = box.max_ - box.min_;
    box_->side = edges;
    box_->computeLocalAABB();
    query_.setTranslation(box.center());
    query_.computeAABB();
    Near asked{&query_, &found_};
    tree_.collide(&query_, &asked, collect);
    return found_;
  }

  std::uint64_t hash_;
  std::vector<std::unique_ptr<CollisionObjectd>> head_, standing_;
  fcl::DynamicAABBTreeCollisionManagerd tree_;
  std::shared_ptr<fcl::Boxd> box_ = std::make_shared<fcl::Boxd>(1, 1, 1);
  CollisionObjectd query_{box_};
  std::vector<CollisionObjectd*> found_;
};

/// How far the body that goes farthest goes from one position of the axes to another.
double carried_mm(const Scene& scene, const AxisVec& from, const AxisVec& to) {
  double most = 0;
  for (const SceneBody& body : scene.head())
    most = std::max(most, norm(scene.carried(body, to) - scene.carried(body, from)) +
                              body.turning_mm * std::abs(scene.turn_of(body, from, to)));
  return most;
}

/// Adds poses of a segment: both ends, and as many between as the step asks for. Where the last one is its start, that
/// is not looked at twice.
void add_poses(const Scene& scene, const Geometry& g, std::vector<AxisVec>& poses) {
  const AxisVec start = point(g, 0);
  const double ends_mm = carried_mm(scene, start, point(g, g.length));
  if (poses.empty() || poses.back() != start) poses.push_back(start);
  // The length of a curve is that of X, Y and Z, or of what turns; the lift may go farther.
  double steps = std::max(1.0, std::ceil((g.degree == 1 ? ends_mm : std::max(ends_mm, g.length)) / kOpinionStep_mm));
  for (const std::size_t before = poses.size();; steps *= 2) {
    double longest_mm = 0;
    for (double k = 1; k <= steps; ++k) {
      const AxisVec next = point(g, g.length * k / steps);
      longest_mm = std::max(longest_mm, carried_mm(scene, poses.back(), next));
      poses.push_back(next);
    }
    constexpr double kRounding_mm = 1e-9;
    if (longest_mm <= kOpinionStep_mm + kRounding_mm) return;
    poses.resize(before);
  }
}

class Fcl {
 public:
  Result<std::size_t> about(const Scene& scene, const ClearanceRules& rules, std::span<const Segment> all) {
    const auto margins = make_margins(scene, rules.clearance_mm, rules.approaches);
    if (!margins) return tl::unexpected(margins.error());
    FclScene& bodies = known(scene);
    std::vector<AxisVec> poses;
    for (const Segment& segment : all)
      if (segment.geometry.degree > 0) add_poses(scene, segment.geometry, poses);
    for (std::size_t first = 0; first < poses.size(); first += kTogether) {
      const auto together = std::span<const AxisVec>(poses).subspan(first, std::min(kTogether, poses.size() - first));
      if (const auto contact = bodies.contact(scene, *margins, together))
        return tl::unexpected(disagreement(scene, rules, *contact, together));
    }
    return poses.size();
  }

 private:
  FclScene& known(const Scene& scene) {
    for (auto& each : scenes_)
      if (each->is_of(scene)) return *each;
    if (scenes_.size() == kScenes) scenes_.pop_front();
    return *scenes_.emplace_back(std::make_unique<FclScene>(scene));
  }

  static Error disagreement(const Scene& scene, const ClearanceRules& rules, const FclScene::Contact& contact,
                            std::span<const AxisVec> poses) {
    const SceneBody &head = scene.head()[contact.head], &standing = scene.standing()[contact.standing];
    const Vec3 point = nearest_point(scene.placed(head, poses[contact.pose]), standing.solid);
    return {Fault::Internal,
            fmt::format("two verdicts on one motion: by the proof it is free and {} keeps {:.3g} mm from {}, but FCL "
                        "says that they meet at {}; one of the two is wrong, and the motion is not played",
                        head.name, rules.clearance_mm, standing.name, scene.told(point)),
            "",
            std::make_shared<Meeting>(Meeting{head.name, standing.name, poses.front(), poses.back(),
                                              poses[contact.pose], point, rules.clearance_mm})};
  }

  std::deque<std::unique_ptr<FclScene>> scenes_;
};

}  // namespace

Opinion fcl_opinion() {
  return [fcl = std::make_shared<Fcl>()](const Scene& scene, const ClearanceRules& rules,
                                         std::span<const Segment> all) -> Result<std::size_t> {
    try {
      return fcl->about(scene, rules, all);
    } catch (const std::exception& error) {  // of FCL, which then has no opinion
      return fail(Fault::Internal, fmt::format("FCL gave up on a motion that was proved free: {}", error.what()));
    }
  };
}

}  // namespace gantry::motion
