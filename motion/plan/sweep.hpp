// Does the head hit anything on a straight motion of the axes? Exact: X, Y, Z and U move together, so each body of the
// head moves along one straight line, and its sweep is one convex query against each body that stands.
//   std::optional<Hit> hit = first_hit(scene, from, to, {.clearance_mm = 2});
// Free is what is proved: a pair whose question stays open counts as hit.
#pragma once
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "motion/plan/scene.hpp"

namespace gantry::motion {

/// A body of the head that may come nearer to one that stands than the clearance, by design: the needle over the board,
/// the probe on it. `clearance_mm` is what they still keep; below 0 it is an allowed overlap, counted along an upright
/// face normal of the standing body or Z (a probe may press in by its travel). It holds for these two bodies and for
/// nothing else.
struct AllowedApproach {
  std::string head, standing;
  double clearance_mm = 0;
  bool by_design = true;  ///< false: they stand that near now, whatever the reason, and come no nearer
};

/// AllowedApproach with its names looked up.
struct PairMargin {
  std::size_t head = 0, standing = 0;
  double clearance_mm = 0;
  bool by_design = true;
};
struct Margins {
  double clearance_mm = 0;
  std::vector<PairMargin> pairs;
  [[nodiscard]] double of(std::size_t head, std::size_t standing) const;
  [[nodiscard]] bool by_design(std::size_t head, std::size_t standing) const;
};
/// Looks names up. `extra_mm` is added to the clearance; an allowed approach says what its pair keeps, everything
/// included.
/// Fault::UnknownReference.
Result<Margins> make_margins(const Scene& scene, double clearance_mm, const std::vector<AllowedApproach>& approaches,
                             double extra_mm = 0);

/// Why a pair stays apart over a motion: along `direction` (unit, towards the standing body) there are `room_mm`
/// between the swept body and the other. verify.hpp checks it again with other code.
struct PairProof {
  std::size_t head = 0, standing = 0;
  Vec3 direction;
  double room_mm = 0;
};

struct Hit {
  std::size_t head = 0, standing = 0;
  double fraction = 0;      ///< of the motion that is free
  Vec3 point;               ///< on the standing body, machine frame
  double clearance_mm = 0;  ///< what was asked of the pair
};

/// One body of the head on one motion; the scene outlives it.
class BodySweep {
 public:
  BodySweep(const Scene& scene, std::size_t head, const AxisVec& from, const AxisVec& to);
  /// Far apart along X, Y or Z, as nearly all pairs are; false says nothing.
  [[nodiscard]] bool far(std::size_t standing, double margin_mm) const noexcept {
    const Scene::Box& b = scene_->boxes()[standing];
    return (std::abs(b.centre.x - middle_.x) - reach_.x - b.half.x > margin_mm) |
           (std::abs(b.centre.y - middle_.y) - reach_.y - b.half.y > margin_mm) |
           (std::abs(b.centre.z - middle_.z) - reach_.z - b.half.z > margin_mm);
  }
  /// Proof that the pair keeps more than the margin; none: it does not, or it cannot be decided.
  [[nodiscard]] std::optional<PairProof> prove(std::size_t standing, double margin_mm) const;
  /// Where the pair first comes as near as the margin; for a pair that has no proof.
  [[nodiscard]] Hit locate(std::size_t standing, double margin_mm) const;

 private:
  const Scene* scene_;
  std::size_t head_;
  Solid start_;
  Vec3 half_box_, sweep_;
  // Boxes along the axes, swept: the cheap test that most pairs pass.
  Vec3 middle_, reach_;
  std::array<Vec3, 3> across_{};  ///< unit, across motion and axis; 0 where the motion is along the axis
};

/// The first body that the straight motion would meet, or none. `proofs` receives one proof for every pair.
std::optional<Hit> first_hit(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                             std::vector<PairProof>* proofs = nullptr);

}  // namespace gantry::motion
