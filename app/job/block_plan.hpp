// From a step of the job to segments: points are put into the machine frame with what is known by then, paths between
// them are found and proved free, and the motions on them are timed. What it plans depends on nothing but machine,
// recipe, knowledge and arguments, so that a planner may live on any thread.
//   BlockPlanner planner(machine, recipe);   planner.know(state.known);
//   auto planned = planner.dispense(block_number, from, features);      // Result<ProvenBlock>
// Errors name both bodies, the point and the line of the recipe. Fault::Aborted when the breath says no, which is asked
// at least once a feature; then nothing has changed.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/job/block_builder.hpp"
#include "app/job/job_state.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/breath.hpp"
#include "core/error.hpp"
#include "motion/types.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

class Surroundings;
struct Work;

class BlockPlanner {
 public:
  /// Machine and recipe outlive it. `opinion`: asked of each motion besides the proof; empty: nobody is.
  BlockPlanner(const config::Machine& machine, const recipes::Recipe& recipe, Breath breath = {},
               motion::Opinion opinion = {});
  ~BlockPlanner();

  /// Board and parts stand where this says (surroundings.hpp: belief_of). What that is among thousands of parts is
  /// worked out when a plan asks for it.
  void know(const Knowledge& known);

  /// What another planner of this machine and recipe has worked out for the same knowledge need not be worked out
  /// again.
  void share(const BlockPlanner& other);

  /// Ways around bodies that were found when the job was planned before, and are taken again where they are free.
  void know_ways(std::shared_ptr<const motion::KnownWays> ways) { known_ways_ = std::move(ways); }
  /// Where those are kept from now on that this planner finds.
  void keep_ways(std::shared_ptr<motion::KnownWays> ways) { kept_ways_ = std::move(ways); }

  /// Called with each feature that is dispensed.
  void count(std::function<void()> features) { count_ = std::move(features); }

  /// Each block lists its motions from now on.
  void list_motions() { rows_.emplace(machine_); }
  /// What lists them; null: nothing does.
  [[nodiscard]] const MotionRows* rows() const { return rows_ ? &*rows_ : nullptr; }

  /// Camera over the mark, light, settle, trigger.
  Result<ProvenBlock> look_at_mark(std::uint32_t block, const AxisVec& from, std::size_t mark) const;
  /// Over the point, and the probe down until it touches; fast where a second, slow touch follows (`probe.fast`).
  Result<ProvenBlock> touch(std::uint32_t block, const AxisVec& from, std::size_t touch) const;
  /// From the first touch straight up by `probe.back_off`, and then down at the speed that counts.
  Result<ProvenBlock> back_off(std::uint32_t block, const AxisVec& from, std::size_t touch) const;
  Result<ProvenBlock> touch_again(std::uint32_t block, const AxisVec& from, std::size_t touch) const;
  /// Straight up from a touch, so that the probe opens again.
  Result<ProvenBlock> retract(std::uint32_t block, const AxisVec& from, std::size_t touch) const;
  /// Over the recipe's purge place, down, its shots, and up again.
  Result<ProvenBlock> purge(std::uint32_t block, const AxisVec& from) const;
  /// Of a bead of which a part lies already, the rest.
  Result<ProvenBlock> dispense(std::uint32_t block, const AxisVec& from, const std::vector<std::size_t>& features,
                               const std::vector<LaidPart>& laid = {}) const;
  /// Straight up by the material's retract from where a stop has left the needle on a feature.
  Result<ProvenBlock> lift(std::uint32_t block, const AxisVec& from, std::size_t feature) const;
  Result<ProvenBlock> park(std::uint32_t block, const AxisVec& from) const;

  /// What it plans among, by what is known now. It may be kept longer than the planner.
  [[nodiscard]] const std::shared_ptr<const Surroundings>& surroundings() const;
  /// Where the camera's tip is meant to be for a mark, machine frame.
  [[nodiscard]] Vec3 mark_view(std::size_t mark) const;
  /// The axes with the probe's tip over a touch, so high above the nominal surface.
  [[nodiscard]] AxisVec probe_at(std::size_t touch, double height_mm) const;

 private:
  /// `last`: what the feature before was dispensed on, and this one afterwards; nothing: this is the first.
  Result<void> add_dot(BlockBuilder& builder, const recipes::Dot& dot, std::size_t index,
                       std::optional<Work>& last) const;
  Result<void> add_bead(BlockBuilder& builder, const recipes::Bead& bead, const LaidPart& laid,
                        std::optional<Work>& last) const;
  [[nodiscard]] Result<BegunBead> begin(const BlockBuilder& builder, motion::BeadSpec spec, const recipes::Material& m,
                                        const motion::PathRules& rules, const Work& work) const;
  [[nodiscard]] Work work_of(const recipes::Bead& bead) const;
  Result<void> leave_bead(BlockBuilder& builder, const recipes::Bead& bead, const motion::PathRules& rules) const;
  [[nodiscard]] Work work_of(const recipes::Material& material, const std::string& on) const;
  [[nodiscard]] motion::PathRules travel_rules(const BlockBuilder& builder, const AxisVec& to,
                                               const std::optional<Work>& last, const Work& work) const;
  Result<void> go_over(BlockBuilder& builder, const AxisVec& to, const std::optional<Work>& last,
                       const Work& work) const;
  [[nodiscard]] Subject subject(std::string_view kind, const std::string& name, recipes::Location location) const;
  [[nodiscard]] AxisVec needle_at(Vec2 at, double height_mm) const;
  [[nodiscard]] double straight_down_mm(const AxisVec& to, const recipes::Material& material, double after_s) const;
  void rise(AxisVec& q, double mm) const;
  [[nodiscard]] AxisVec lifted(AxisVec q, const recipes::Material& material) const;

  Result<ProvenBlock> down(BlockBuilder builder, std::size_t touch, double speed_mm_s, const std::string& words) const;
  Result<ProvenBlock> up(std::uint32_t block, const AxisVec& from, std::size_t touch, double by_mm) const;

  [[nodiscard]] Result<ProvenBlock> over_board(ProvenBlock block, std::string words, recipes::Location location) const;
  [[nodiscard]] BlockBuilder build(std::uint32_t block, const AxisVec& from) const;
  [[nodiscard]] recipes::WorkOffset offset() const { return known_.offset.value_or(recipes::WorkOffset{}); }
  [[nodiscard]] recipes::Surface surface() const { return known_.surface.value_or(recipes::Surface{}); }

  const config::Machine& machine_;
  const recipes::Recipe& recipe_;
  Breath breath_;
  std::function<void()> count_;
  motion::Opinion opinion_;
  std::optional<MotionRows> rows_;
  std::shared_ptr<const motion::KnownWays> known_ways_;
  std::shared_ptr<motion::KnownWays> kept_ways_;
  motion::Limits limits_;
  Knowledge known_;
  mutable std::shared_ptr<const Surroundings> surroundings_;  ///< null: nobody has asked since it changed
};

}  // namespace gantry::job
