// An axis that answers its target later than others is sent ahead of them (motion/rt/compensation.hpp): while axes
// move, the targets of one cycle stand beside the path that the tool keeps. This proves that they keep the clearance
// there, too, at the planned rate and at every lower one (a hold, an override), at any moment and not at ticks alone.
//   const AsSent sent(scene, limits, motion);      // segments from rest to rest; their own proof is the path's
//   Result<void> free = sent.certify(0, sent.duration_s(), rules);
// A pair with an allowed approach is held to the path, and as sent it may be nearer by what the targets are beside it.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "core/breath.hpp"
#include "core/error.hpp"
#include "motion/plan/certificate.hpp"
#include "motion/plan/scene.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

class AsSent {
 public:
  /// All three outlive it. `motion` may end in motion where it is a run-up.
  AsSent(const Scene& scene, const Limits& limits, std::span<const Segment> motion);

  [[nodiscard]] double duration_s() const { return ends_s_.empty() ? 0 : ends_s_.back(); }
  /// Axes that answer alike, or one axis alone, are sent along the path itself.
  [[nodiscard]] bool beside_path() const { return spread_s_ > 0; }

  /// The part of the motion from `begin_s` to `end_s`, by the rules of its path. Where axes that move answer alike,
  /// targets are on the path, and nothing is asked. Fault::Collision with both bodies and the point; Fault::Internal
  /// when the two collision checks disagree; Fault::UnknownReference and Fault::Aborted as certify().
  [[nodiscard]] Result<void> certify(double begin_s, double end_s, const ClearanceRules& rules,
                                     const Breath& breath = {}) const;

 private:
  struct At {
    AxisVec q{}, v{};
  };
  struct Sweep {
    AxisVec from{}, to{};
    double extra_mm = 0;
  };
  /// What goes on about a piece of the motion, from the earliest target to the latest that belong to it.
  struct Around {
    bool beside_path = false;  ///< axes that move there have unlike delays
    bool line = false;         ///< and go along one straight line, in this direction, no faster than this
    AxisVec direction{};
    double fastest = 0;
    AxisVec acceleration{};  ///< bounds
  };
  struct Asked;
  [[nodiscard]] At at(double t) const;
  [[nodiscard]] double middle_delay_s(const AxisVec& v) const;
  [[nodiscard]] Around around(double begin_s, double end_s) const;
  [[nodiscard]] Sweep along(const At& x, const Around& near, double middle_s, double half_s) const;
  [[nodiscard]] Sweep across(const At& x, const Around& near, double middle_s, double half_s, double from_rate,
                             double to_rate) const;
  [[nodiscard]] Result<std::optional<Hit>> hit_by(const Sweep& sweep, Asked& asked) const;
  [[nodiscard]] Result<void> prove(double begin_s, double end_s, Asked& asked) const;

  const Scene& scene_;
  const Limits& limits_;
  std::span<const Segment> motion_;
  std::vector<double> ends_s_;
  std::vector<std::size_t> axes_;  ///< that move, and carry or turn a body
  double middle_s_ = 0, spread_s_ = 0;
};

/// No point of the head goes farther when each axis goes so far, mm or rad.
double farthest_mm(const Scene& scene, const AxisVec& displacement);

/// How far targets on a straight line from rest to rest are beside it at most, mm: of all lags that are the same for
/// each axis the one leaves least that is the mean of their delays, weighted with the squares of their speeds.
double beside_line_mm(const Limits& limits, const Segment& line);

}  // namespace gantry::motion
