// A block of a job as a value: which step, where the axes stand when it begins, and what is known by then. What is
// planned of it depends on nothing else, so that a block that was planned ahead is the one that is wanted when both are
// equal.
//   BlockWanted wanted{recipes::Park{}, number, at, state.known};   auto planned = plan(planner, wanted);
#pragma once
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "app/job/block_plan.hpp"
#include "app/job/job_state.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

/// Of a machine with a fast touch: up from it, and the slow one.
struct BackOff {
  std::size_t touch = 0;
  bool operator==(const BackOff&) const = default;
};
struct TouchAgain {
  std::size_t touch = 0;
  bool operator==(const TouchAgain&) const = default;
};
using BlockStep = std::variant<recipes::LookAtMark, recipes::Touch, BackOff, TouchAgain, Retract, recipes::PurgeNeedle,
                               recipes::Dispense, recipes::Park>;

struct BlockWanted {
  BlockStep step;
  std::uint32_t number = 0;
  AxisVec from{};
  Knowledge known;
  std::vector<LaidPart> laid{};  ///< of beads that are joined
  bool operator==(const BlockWanted&) const = default;
};

/// By a planner that knows `wanted.known`.
Result<ProvenBlock> plan(const BlockPlanner& planner, const BlockWanted& wanted);

/// The block that comes next as things stand, with nothing more to be measured before it; nothing where an answer of
/// the world comes first, where what was measured is refused, or at the end. `purges`: the valve has been shut for so
/// long.
std::optional<BlockWanted> wanted_next(const recipes::Recipe& recipe, const recipes::Job& job, JobState state,
                                       bool purges, std::uint32_t number, const AxisVec& from);

}  // namespace gantry::job
