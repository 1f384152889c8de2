// From a block of the job to segments: points are placed into the machine frame with what is known by then, ways
// between them are found and proved free, and the motions on them are timed. A pure function of its inputs.
//   BlockPlanner planner(machine, recipe);   planner.know(offset, surface);
//   auto planned = planner.dispense(block_number, from, features);      // Result<PlannedBlock>
// Errors name both bodies, the point and the line of the recipe.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/job/block_builder.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "motion/types.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

class Surroundings;

class BlockPlanner {
 public:
  BlockPlanner(const config::Machine& machine, const recipes::Recipe& recipe);
  ~BlockPlanner();

  /// Board and parts stand where this says; before, they are taken at their nominal place and kept clear of by what the
  /// recipe's rules allow them to be off.
  void know(const recipes::WorkOffset& offset, const recipes::Surface& surface, bool surface_measured);
  /// A guess for where the next mark is, from the marks that were found.
  void guess(const recipes::WorkOffset& offset) { guess_ = offset; }

  /// Camera over the mark, light, settle, trigger.
  Result<PlannedBlock> look_at_mark(std::uint32_t block, const AxisVec& from, std::size_t mark) const;
  /// Probe down until it touches.
  Result<PlannedBlock> touch(std::uint32_t block, const AxisVec& from, std::size_t touch) const;
  /// Straight up to the safe height, from wherever a stop has left the head; nothing when it is up there
  /// already. As in homing (Z first) the way is free by declaration: what is near is what it was just working on.
  std::optional<PlannedBlock> rise(std::uint32_t block, const AxisVec& from) const;
  /// Straight up from a touch, so that the probe opens again.
  Result<PlannedBlock> retract(std::uint32_t block, const AxisVec& from) const;
  Result<PlannedBlock> dispense(std::uint32_t block, const AxisVec& from,
                                const std::vector<std::size_t>& features) const;
  Result<PlannedBlock> park(std::uint32_t block, const AxisVec& from) const;

  /// What it plans among, by what is known now; outlives the planner.
  [[nodiscard]] const std::shared_ptr<const Surroundings>& surroundings() const { return surroundings_; }
  /// Where the camera's tip is meant to be for a mark, machine frame.
  [[nodiscard]] Vec3 mark_view(std::size_t mark) const;

 private:
  /// `gap_mm`: of the feature before, and of this one afterwards.
  Result<void> add_dot(BlockBuilder& builder, const recipes::Dot& dot, std::size_t index, double& gap_mm) const;
  Result<void> add_bead(BlockBuilder& builder, const recipes::Bead& bead, std::size_t index, double& gap_mm) const;
  [[nodiscard]] AxisVec needle_at(Vec2 at, double height_mm) const;
  [[nodiscard]] AxisVec lifted(AxisVec q, const recipes::Material& material) const;

  const config::Machine& machine_;
  const recipes::Recipe& recipe_;
  motion::Limits limits_;
  recipes::WorkOffset guess_, offset_;
  recipes::Surface surface_;
  std::shared_ptr<const Surroundings> surroundings_;
};

}  // namespace gantry::job
