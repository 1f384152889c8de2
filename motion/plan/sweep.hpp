// Does the head hit anything on a straight motion of the axes? Exact: X, Y, Z and U move together, so each body of the
// head moves along one straight line, and its sweep is one convex query against each body that stands.
//   std::optional<Hit> hit = first_hit(scene, from, to, {.clearance_mm = 2});
// A body that turns with C meanwhile is taken as it stands half-way, and larger all around in the plane by what it can
// be off that: its radius times half of the turn. Where that is not free, the motion is cut into halves, and these
// again. Free is what is proved: a pair whose question stays open counts as hit. A tree over what stands finds the few
// pairs that are near; all others are parted off with the box that holds them.
#pragma once
#include <array>
#include <cstdint>
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
  std::optional<double> lowest_mm{};  ///< of a path that is looked for, where its ends are no lower
  [[nodiscard]] double of(std::size_t head, std::size_t standing) const;
  [[nodiscard]] bool by_design(std::size_t head, std::size_t standing) const;
};
/// Looks names up. `extra_mm` is added to the clearance and to what an allowed approach keeps. Fault::UnknownReference.
Result<Margins> make_margins(const Scene& scene, double clearance_mm, const std::vector<AllowedApproach>& approaches,
                             double extra_mm = 0);

/// Contact counts as meeting: a pair is apart when there is more than the margin and this between them.
inline constexpr double kContact_mm = 1.02e-9;

/// Why a body of the head and a node of the tree (a box with all that is in it, or one body) stay apart over a motion:
/// along `direction` (unit, towards what stands) there is more room than the margin. verify.hpp checks it with other
/// code. A proof of a motion is one after the other: for each body of the head, in the order of the tree. Of a body
/// that turns the motion may be proved in parts, one after the other; this is of the one that ends at `upto`.
struct Separation {
  std::uint32_t head = 0, node = 0;
  Vec3 direction;
  double upto = 1;
};
using Proof = std::vector<Separation>;

/// How much of a turn may be left open: what comes that much nearer than the margin to a body that turns counts as hit.
inline constexpr double kTurn_mm = 1e-3;

struct Hit {
  std::size_t head = 0, standing = 0;
  double fraction = 0;      ///< of the motion that is free
  Vec3 point;               ///< on the standing body, machine frame
  double clearance_mm = 0;  ///< what was asked of the pair
};

/// One body of the head on one motion, as a whole: one that turns is larger by what its turn leaves open. The scene
/// outlives it.
class BodySweep {
 public:
  /// `other`: a body of the same motion, whose directions this one takes over when it is carried along the same line.
  BodySweep(const Scene& scene, std::size_t head, const AxisVec& from, const AxisVec& to,
            const BodySweep* other = nullptr);
  /// Direction (unit, towards the box) along which the box is parted off by more than the margin; 0: that was not seen.
  [[nodiscard]] Vec3 parts(const Box& box, double margin_mm) const noexcept;
  /// The same as yes or no, and quicker.
  [[nodiscard]] bool far(const Box& box, double margin_mm) const noexcept;
  /// What is surely left between the two, along axes and across the motion; may be less than 0.
  [[nodiscard]] double room(const Box& box) const noexcept;
  /// Direction that proves that the pair keeps more than the margin; none: it does not.
  [[nodiscard]] std::optional<Vec3> prove(std::size_t standing, double margin_mm) const;
  /// Where the pair first comes as near as the margin; for a pair that has no proof.
  [[nodiscard]] Hit locate(std::size_t standing, double margin_mm) const;
  /// The swept box as the wide tree wants it.
  [[nodiscard]] WideQuestion question(double margin_mm) const;
  /// The motion ends here: what comes later is of no interest.
  void cut(double fraction);
  /// By so much it is larger in the plane than what is swept.
  [[nodiscard]] double left_open_mm() const { return start_.disc; }
  [[nodiscard]] const Solid& start() const { return start_; }
  [[nodiscard]] Vec3 sweep() const { return sweep_; }

 private:
  void look_around();
  const Scene* scene_;
  std::size_t head_;
  Solid start_;
  Vec3 half_box_, sweep_;
  double cut_ = 1;
  // Boxes along the axes, swept: the cheap test that most pairs pass.
  Vec3 middle_, reach_;
  std::array<Vec3, 3> across_{};        ///< unit, across motion and axis; 0 where the motion is along the axis
  std::array<Vec3, 3> across_parts_{};  ///< the same without signs
};

/// The first body that the straight motion would meet, or none. `proof` is one of the motion when there is none.
std::optional<Hit> first_hit(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                             Proof* proof = nullptr);
/// Only whether there is one.
bool is_clear(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins);
/// Whether one pair keeps more than its margin.
bool is_clear(const Scene& scene, std::size_t head, std::size_t standing, const AxisVec& from, const AxisVec& to,
              double margin_mm);
/// On the straight line of the axes; its ends to the last bit.
inline AxisVec on_line(const AxisVec& from, const AxisVec& to, double fraction) {
  return fraction <= 0 ? from : fraction >= 1 ? to : between(from, to, fraction);
}

}  // namespace gantry::motion
