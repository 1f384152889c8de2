// Proof that a polyline of the axes is free, and how near it comes to what stands there.
//   Result<Certificate> c = certify(scene, points, {.clearance_mm = 2, .approaches = {...}}, off_mm);
// A curve is proved by its chords: how far it may be off them is added to all that is asked, allowed approaches too.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/breath.hpp"
#include "core/error.hpp"
#include "core/meeting.hpp"
#include "motion/plan/sweep.hpp"

namespace gantry::motion {

struct ClearanceRules {
  double clearance_mm = 2;                  ///< from every body, over and above path deviation
  std::vector<AllowedApproach> approaches;  ///< pairs that may come nearer
  /// A path that turns aside goes no lower than this, or than its lower end: of wet deposits, which are no bodies.
  std::optional<double> lowest_mm{};
};

/// The two bodies that come nearest to each other; of one that turns on the motion the distance is told up to 0.01 mm
/// too small. `distance_mm` is infinite where there is no such pair, below 0 where an allowed overlap lets one into the
/// other.
struct NearPair {
  double distance_mm = std::numeric_limits<double>::infinity();
  std::size_t head = 0, standing = 0;  ///< indices in the scene
  std::size_t motion = 0;              ///< of the polyline, from 0
  double fraction = 0;                 ///< of that motion: there they are that near
  Vec3 at;                             ///< on the standing body, machine frame
};
/// Pairs that are near by design (AllowedApproach) are told apart from all others: a needle over what it dispenses on
/// would hide them.
struct NearPairs {
  NearPair by_design, others;
};

/// What is measured besides of motions that are proved; it costs more than proving.
struct Measuring {
  NearPairs known;           ///< only pairs that come nearer than these are looked for
  bool each_motion = false;  ///< and the nearest of each motion by itself
};

struct Certificate {
  std::uint64_t scene_hash = 0;
  double clearance_mm = 0, extra_mm = 0;  ///< what was asked
  std::size_t motions = 0;                ///< that were proved
  std::size_t pairs = 0;                  ///< that were proved apart, over all motions
  NearPairs nearest;
  std::vector<NearPairs> of_motion{};  ///< by the number of the motion, where each was to be measured
};

/// Fault::Collision with both bodies, the point and the number of the motion; Fault::Internal when the second check
/// contradicts the first; Fault::UnknownReference for an allowed approach that names a body which is not there;
/// Fault::Aborted when the breath, which is asked between two motions, says no.
Result<Certificate> certify(const Scene& scene, std::span<const AxisVec> polyline, const ClearanceRules& rules,
                            double extra_mm = 0, const Breath& breath = {}, const Measuring& measuring = {});

/// Puts into `nearest` what comes nearer on a motion than what stands there; `motion` is its number.
void measure_nearest(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                     std::size_t motion, NearPairs& nearest);

/// "needle comes within 2 mm of part U7 at (12.00, 8.00, 21.50) mm [machine 192.00, 158.00, -88.50]"
std::string describe(const Scene& scene, const Hit& hit);

/// Fault::Collision with these words; what a picture of the hit needs goes with it.
Error collision(const Scene& scene, const Hit& hit, const AxisVec& from, const AxisVec& to, std::string words);

}  // namespace gantry::motion
