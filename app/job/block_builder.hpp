// Collects the segments of one block. Every motion is certified before it is taken, and nothing else can be added.
//   BlockBuilder builder(limits, scene, number, from);   builder.straight(to, rules);   return builder.finish();
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

#include "app/job/proven_block.hpp"
#include "core/axis_vec.hpp"
#include "core/breath.hpp"
#include "core/error.hpp"
#include "motion/path/bead.hpp"
#include "motion/path/moves.hpp"
#include "motion/plan/find_path.hpp"
#include "motion/plan/scene.hpp"
#include "motion/plan/second_opinion.hpp"
#include "motion/types.hpp"
#include "recipes/recipe.hpp"

namespace gantry::job {

/// What motions are for: "dot 'd[0][1]'" and its line. The texts outlive the builder.
struct Subject {
  std::string_view kind, name;
  std::string_view file;  ///< empty: no line of a recipe asks for it
  recipes::Place place{};
};

class BlockBuilder {
 public:
  /// Limits and scenes outlive it. A breath that says no ends an addition with Fault::Aborted. A second opinion is
  /// asked of each motion that was certified; its error is the addition's.
  BlockBuilder(const motion::Limits& limits, const motion::Scene& scene, std::uint32_t block, const AxisVec& from,
               Breath breath = {}, motion::Opinion opinion = {});

  /// What the motions that follow are for.
  void about(const Subject& subject) { subject_ = subject; }
  /// They go among these bodies.
  void among(const motion::Scene& scene) { scene_ = &scene; }

  /// A path that is free, straight or over what stands there.
  Result<void> travel(const AxisVec& to, const motion::PathRules& rules);
  /// Straight, where a detour would make no sense (down to the surface, up from it) or is not wanted.
  Result<void> straight(const AxisVec& to, const motion::PathRules& rules, double v_cap = motion::kNoCap);
  /// Straight until the probe latches, and `to` at most. The axes rest somewhere on that line; at() stays where it
  /// began.
  Result<void> until_probe(const AxisVec& to, const motion::PathRules& rules, double speed_mm_s);
  /// A bead from its start, where the axes must stand.
  Result<void> bead(const motion::BeadMotion& bead, const motion::PathRules& rules, std::uint32_t feature);
  /// Stands where it is; at_s of the events is in seconds.
  void dwell(double seconds, std::span<const motion::OutputEvent> events = {}, std::uint32_t feature = motion::kTravel);
  [[nodiscard]] ProvenBlock finish();

  [[nodiscard]] const AxisVec& at() const { return at_; }

 private:
  Result<void> prove(std::span<const AxisVec> polyline, const motion::PathRules& rules, std::string_view leg,
                     double off_mm = 0);
  Result<void> ask(std::span<const motion::Segment> segments, const motion::PathRules& rules);
  void count(const motion::Certificate& certificate, std::span<const AxisVec> polyline, std::string_view leg);
  void take(std::span<const motion::Segment> segments, const AxisVec& end, std::uint32_t feature = motion::kTravel);

  const motion::Limits& limits_;
  const motion::Scene* scene_;
  AxisVec at_;
  Breath breath_;
  motion::Opinion opinion_;
  Subject subject_{};
  motion::NearPairs known_;  ///< the nearest so far: only what is nearer is measured
  ProvenBlock out_;
};

}  // namespace gantry::job
