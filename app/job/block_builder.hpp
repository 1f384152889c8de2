// Collects the segments of one block. Every motion is certified before it is taken, and nothing else can be added
// but the walk of an axis where nothing knows where the head stands.
//   BlockBuilder builder(limits, scene, number, from);   builder.straight(to, rules);   return builder.finish();
// Up from where something was worked on, away, and down to what is next: these wait for each other, and become one
// motion (motion/path/arch.hpp) where that is free and quicker.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "app/job/motion_rows.hpp"
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
  recipes::Location location{};
};

class BlockBuilder {
 public:
  /// Limits and scenes outlive it. A breath that says no ends an addition with Fault::Aborted. A second opinion is
  /// asked of each motion that is taken; its error is that of the addition that it was taken for, or of finish().
  BlockBuilder(const motion::Limits& limits, const motion::Scene& scene, std::uint32_t block, const AxisVec& from,
               Breath breath = {}, motion::Opinion opinion = {});
  BlockBuilder(BlockBuilder&&) = default;
  /// What was not finished is freed as a block is that is over.
  ~BlockBuilder() { discard(std::move(out_), breath_); }

  /// What the motions that follow are for.
  void about(const Subject& subject) { subject_ = subject; }
  /// Each motion is listed in the block. They outlive it; null: none is.
  void list(const MotionRows* rows) { rows_ = rows, measuring_.each_motion = rows != nullptr; }
  /// Ways around bodies that were found before, and where those that are found from now on are kept. They outlive it;
  /// null: none.
  void ways(const motion::KnownWays* known, motion::KnownWays* kept) { known_ways_ = known, kept_ways_ = kept; }
  /// They go among these bodies.
  void among(const motion::Scene& scene) { scene_ = &scene; }

  /// A path that is free, straight or over what stands there. `turning`: what has to be kept where it is blended with
  /// the motions up and down.
  Result<void> travel(const AxisVec& to, const motion::PathRules& rules, const motion::PathRules& turning);
  Result<void> travel(const AxisVec& to, const motion::PathRules& rules) { return travel(to, rules, rules); }
  /// Straight up from where something is worked on, or down to it; nothing else moves within `alone_mm` of there.
  Result<void> vertical(const AxisVec& to, const motion::PathRules& rules, double alone_mm);
  /// Straight from rest to rest, where a detour would make no sense or is not wanted; slower where targets, as they are
  /// sent, would come too near to a body (motion/plan/as_sent.hpp).
  Result<void> straight(const AxisVec& to, const motion::PathRules& rules, double v_cap = motion::kNoCap);
  /// One axis by a short distance, where it is not known where the head stands: nothing can be proved among bodies
  /// then, and what this makes is played as Purpose::Walk alone. Fault::Internal when more than one axis moves, or one
  /// by more than `most`.
  Result<void> unplaced(const AxisVec& to, double v_cap, double most);
  /// Straight until the probe latches, and `to` at most. The axes rest somewhere on that line; at() stays where it
  /// began.
  Result<void> until_probe(const AxisVec& to, const motion::PathRules& rules, double speed_mm_s);
  /// Whether a polyline would be free, `off_mm` for how far what is played may be off it. Nothing is added.
  [[nodiscard]] Result<void> would_be_free(std::span<const AxisVec> polyline, const motion::PathRules& rules,
                                           double off_mm = 0) const;
  /// Whether segments would be, on their path and as their targets are sent.
  [[nodiscard]] Result<void> would_be_free(std::span<const motion::Segment> segments,
                                           const motion::PathRules& rules) const;
  /// A bead from its start, where the axes must stand.
  Result<void> bead(const motion::BeadMotion& bead, const motion::PathRules& rules, std::uint32_t feature);
  /// A path from where the axes stand, from rest to rest. Fault::Collision and nothing added: it, or its targets as
  /// they are sent, come too near to a body.
  Result<void> path(std::span<const motion::Segment> segments, const AxisVec& to, const motion::PathRules& rules,
                    std::string_view leg);
  /// Stands where it is; at_s of the events is in seconds.
  Result<void> dwell(double seconds, std::span<const motion::OutputEvent> events = {},
                     std::uint32_t feature = motion::kTravel);
  /// Of a bead that was added: it is not begun as beads are.
  void begun(RunUp how) { out_.run_ups_.push_back(std::move(how)); }
  Result<ProvenBlock> finish();

  /// Where the axes stand after all that was added.
  [[nodiscard]] const AxisVec& at() const { return at_; }

 private:
  /// What was proved and is not taken yet.
  struct Proved {
    std::string_view leg;
    std::vector<AxisVec> points{};
    motion::PathRules rules{};
    std::optional<motion::PathRules> turning{};  ///< of a path; a motion up or down has none
    double alone_mm = 0;
    motion::Certificate certificate{};
    const motion::Scene* scene = nullptr;
    Subject subject{};
    bool has_room = false;                             ///< of a path: looked for anew
    std::vector<std::vector<motion::Segment>> fast{};  ///< its straights, where they are proved as they are sent
  };
  /// A part of a motion with what it has to keep.
  struct Part {
    std::span<const motion::Segment> segments;
    const Proved* by = nullptr;
    const motion::PathRules* rules = nullptr;
    std::vector<AxisVec> chords{};
    motion::Certificate certificate{};
  };

  Result<void> prove(std::span<const AxisVec> polyline, const motion::PathRules& rules, std::string_view leg,
                     double off_mm = 0);
  [[nodiscard]] std::string_view up_or_down(const AxisVec& to) const;
  [[nodiscard]] Result<std::vector<motion::Segment>> line(const motion::Scene& scene, const AxisVec& from,
                                                          const AxisVec& to, const motion::PathRules& rules,
                                                          double v_cap = motion::kNoCap) const;
  /// `optional`: a plan goes on without one.
  [[nodiscard]] Result<motion::Path> find_path(const motion::Scene& scene, const AxisVec& from, const AxisVec& to,
                                               const motion::PathRules& rules, bool optional) const;
  [[nodiscard]] Result<double> go_fast(Proved& path) const;
  Result<void> wait_for_next(Proved proved);
  Result<void> settle();
  Result<bool> find_room(std::span<Proved> legs) const;
  bool find_room_above(Proved& path, double beside_mm) const;
  Result<bool> take_as_arch(std::span<const Proved> legs);
  Result<void> prove_parts(std::span<Part> parts, std::span<const motion::Segment> all) const;
  Result<void> take_legs(std::span<const Proved> legs);
  Result<void> ask(const motion::Scene& scene, std::span<const motion::Segment> segments,
                   const motion::PathRules& rules);
  void count(const Proved& proved, const motion::Certificate& certificate, std::span<const AxisVec> polyline);
  /// They were proved free; here it is looked whether they are what a plan has to be (motion/path/sound.hpp). `capped`,
  /// a part of them, keeps its set speed.
  Result<void> take(std::span<const motion::Segment> segments, const AxisVec& end,
                    std::uint32_t feature = motion::kTravel, std::span<const motion::Segment> capped = {});

  const motion::Limits& limits_;
  const motion::Scene* scene_;
  AxisVec at_;      ///< where what is proved ends
  AxisVec played_;  ///< where what is taken ends
  Breath breath_;
  motion::Opinion opinion_;
  Subject subject_{};
  motion::Measuring measuring_;  ///< the nearest so far: only what is nearer is measured
  const MotionRows* rows_ = nullptr;
  const motion::KnownWays* known_ways_ = nullptr;
  motion::KnownWays* kept_ways_ = nullptr;
  /// At most a motion up, a path and a motion down, in this order.
  std::vector<Proved> waiting_;
  ProvenBlock out_;
};

}  // namespace gantry::job
