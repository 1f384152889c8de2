// Watches the head for contact with anything solid while it moves. Every motion between two syncs is walked in steps of
// at most 0.2 mm where bounds meet, which a tree over what stands finds; a pair counts once until it has been apart.
//   CollisionWatch watch(head);   watch.set_solids(solids_of(...));   for (const Contact& c : watch.step(from, to,
//   0.001)) ...
// The probe may touch: slowly, straight down, and no deeper than its spring. Anything else is a collision.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/axis_vec.hpp"
#include "sim/world/head.hpp"
#include "sim/world/obstacles.hpp"
#include "sim/world/overlap.hpp"
#include "sim/world/solid_tree.hpp"

namespace gantry::sim {

struct Contact {
  std::string_view moving, standing;
  Vec3 at;
};

inline constexpr double kTouchSpeed_mm_s =
    config::kVirtualProbeBears_mm_s;               ///< at contact, or on the mean over the time before it
inline constexpr double kTouchSpeedOver_s = 0.05;  ///< a host that stands still lets a slow probe catch up at once
inline constexpr double kTouchOvertravel_mm = 2;   ///< spring of a touch probe
inline constexpr double kTouchDrag_mm = 0.05;

class CollisionWatch {
 public:
  explicit CollisionWatch(const Head& head);

  /// Pairs in contact whose solid is still there stay in contact.
  void set_solids(std::vector<Solid> solids);
  [[nodiscard]] const std::vector<Solid>& solids() const { return solids_; }

  /// Solids over or under a point, and those that may be a hair beside it: all others are not. Valid until the next
  /// call.
  std::span<const std::uint32_t> solids_at(Vec2 at);

  /// New collisions on the straight line between two axis positions; valid until the next call.
  std::span<const Contact> step(const AxisVec& from, const AxisVec& to, double dt_s);

 private:
  enum class PairState : std::uint8_t { Apart, ProbeTouch, Collided };
  struct Pair {
    PairState state = PairState::Apart;
    Vec3 since;  ///< where the moving body was when a probe touch began
  };
  /// Where a body of the head is.
  struct Pose {
    Vec3 centre;
    double turn_rad = 0;  ///< from how it is configured
  };
  [[nodiscard]] Pose pose(std::size_t body, const AxisVec& q) const;
  [[nodiscard]] Bounds bounds(std::size_t body, const Pose& at) const;
  void step_pair(std::size_t body, std::size_t solid, const AxisVec& from, const AxisVec& to, double dt_s);
  void part(std::size_t body, std::size_t solid);
  void part_what_is_left_behind(std::size_t body, const Bounds& swept);
  void collide(std::size_t body, std::size_t solid, const Pose& at);
  [[nodiscard]] Vec3 meeting_point(std::size_t body, std::size_t solid, const Pose& at) const;
  [[nodiscard]] bool slow_of_late(double travelled_mm, double dt_s) const;
  [[nodiscard]] bool overlaps(std::size_t body, std::size_t solid, const Pose& at);

  const Head& head_;
  std::vector<OverlapShape> body_shapes_, solid_shapes_;
  std::vector<Solid> solids_;
  std::vector<Bounds> body_bounds_;  ///< about the body's centre, as it is configured
  std::vector<Bounds> solid_bounds_;
  SolidTree tree_;                   ///< over solid_bounds_
  std::vector<std::uint32_t> near_;  ///< solids that the last question found
  std::vector<Pair> pairs_;          ///< body * solids + solid
  std::vector<Contact> contacts_;    ///< of this step
  struct Index {
    std::size_t body = 0, solid = 0;
  };
  std::vector<Index> in_contact_;  ///< pairs that are not apart
  struct Went {
    double travelled_mm = 0, dt_s = 0;
  };
  std::array<Went, 256> went_{};  ///< the probe's last steps, a ring
  std::size_t steps_ = 0;
  bool fresh_ = true;  ///< solids have changed: look even when nothing moves
};

}  // namespace gantry::sim
