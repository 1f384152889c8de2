// The proof before motion: every motion of a job with the board at its nominal position, planned and certified without
// a machine.
#pragma once
#include <vector>

#include "app/job/forecast.hpp"
#include "app/job/job_state.hpp"
#include "app/job/nearest.hpp"
#include "app/job/run_up.hpp"
#include "app/job/slow_beads.hpp"
#include "app/job/wherever.hpp"
#include "config/machine.hpp"
#include "core/breath.hpp"
#include "core/error.hpp"
#include "core/progress.hpp"
#include "motion/plan/second_opinion.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

struct NominalProof {
  std::size_t motions = 0;
  std::size_t poses = 0;  ///< along them, of which a second opinion was asked
  Clearances nearest;
  Forecast forecast;
  std::vector<Next> steps;  ///< that were proved, in order
  std::vector<OnlyWhenPlaced> only_when_placed;
  std::vector<SlowBead> slow_beads;  ///< in the order of the job
  std::vector<RunUp> run_ups;        ///< of beads that are not begun after a whole one, in the same order
};

/// From the park position through all blocks and back. Fault::Collision, OutOfReach, SpeedNotReachable with the
/// recipe's line; Fault::Aborted when the breath says no; what the second opinion says, if there is one. Its progress
/// is counted in features, each at the nominal place, and again wherever the board may be found.
Result<NominalProof> prove_nominal(const config::Machine& machine, const recipes::Recipe& recipe,
                                   const recipes::Job& job, const Breath& breath = {},
                                   const motion::Opinion& opinion = {}, const Progress& progress = {});

}  // namespace gantry::job
